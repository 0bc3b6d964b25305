// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "ground.hpp"
#include "waymark/config/config.hpp"

namespace waymark::simulator {

/// The key of the floors, whose walls and boxes `read_world` reads.
inline const Config::Key kFloorsKey{"floors", "floors above the ground, with what stands on them"};

/// Height of the upper side of one item of `floors` [m]. Throws ConfigError.
double floor_height(const Config& floor);

/// Reads `ramps_m`, `ramp_rounding_m`, `floors` and `bumps`. Throws ConfigError.
Ground read_ground(const Config& config, std::uint64_t seed);

}  // namespace waymark::simulator
