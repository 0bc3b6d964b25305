// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "placing.hpp"
#include "waymark/config/config.hpp"
#include "world.hpp"

namespace waymark::simulator {

/// Builds the world from the blocks `landmarks` (an explicit list, or cylinders drawn at random) and `clutter`, and the
/// keys `walls_m`, `boxes_m`, `wall_height_m`, `ground` and `ceiling_m`, and what stands on the `floors`. What is drawn
/// keeps clear of `path` and of the rest. Throws ConfigError, also if things do not fit or stand on the path.
World read_world(const Config& config, const Ground& ground, const Path& path, std::uint64_t default_seed);

}  // namespace waymark::simulator
