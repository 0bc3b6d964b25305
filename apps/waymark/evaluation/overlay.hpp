// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace waymark::evaluation {

/// A trajectory of a picture.
struct OverlayPath {
  std::string name;                     ///< for the legend; "reference" is drawn in black
  std::vector<Eigen::Vector2d> points;  ///< east, north [m]
};

/// The paths on top of each other as SVG: one scale, a grid with its step in the caption, a legend. The first one is at
/// the bottom.
std::string overlay_svg(const std::vector<OverlayPath>& paths);

}  // namespace waymark::evaluation
