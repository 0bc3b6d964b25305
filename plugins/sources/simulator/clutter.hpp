// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "placing.hpp"
#include "waymark/config/config.hpp"
#include "world.hpp"

namespace waymark::simulator {

/// Adds what the block `clutter` asks for: stones, boxes and corners that stand still and that a scanner may take for a
/// landmark. They keep clear of `path`, of the landmarks and of each other. Throws ConfigError if they do not fit.
void add_clutter(const Config& config, const Path& path, double wall_height_m, std::uint64_t default_seed,
                 World& world);

}  // namespace waymark::simulator
