// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "canvas.hpp"
#include "picture.hpp"

namespace waymark::plot {

/// Position in the plane: east, north [m].
inline Eigen::Vector2d planar(const Pose& pose) { return pose.p.head<2>(); }

/// 1, 2 or 5 times a power of ten, the smallest that is at least `least` (> 0).
double round_step(double least);

/// The view into `area` that shows the window of the style, or all of the content, with a margin; of the GNSS fixes all
/// but the outermost hundredth.
View make_view(const Content& content, const Style& style, const Rect& area);

}  // namespace waymark::plot
