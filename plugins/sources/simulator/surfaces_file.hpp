// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "world.hpp"

namespace waymark::simulator {

/// The true surfaces as CSV, for scores of dense maps: what stands there by its ground plan and height, then ground and
/// ceiling. `kind,x_m,y_m,x2_m,y2_m,half_width_m,height_m`; the plan of a box or wall is a line as thick as twice its
/// half width, that of a cylinder its centre and radius. Where the ground is not level the columns `base_m,height2_m`
/// follow, and the kinds `ground`, `floor`, `ramp` and `wave`: see the README.
std::string surfaces_csv(const World& world);

}  // namespace waymark::simulator
