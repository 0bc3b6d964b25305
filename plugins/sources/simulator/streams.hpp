// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "waymark/base/time.hpp"
#include "waymark/math/random.hpp"

namespace waymark::simulator {

/// What a random draw is for. The numbers are far from any index of a sensor: a filter that runs with the simulator's
/// seed must not draw the very numbers that made the noise.
enum class Draw : std::uint32_t {
  slip = 0x53494d00,
  landmarks,
  wheels,
  gps,
  lidar,
  misses,
  clutter,
  textures,
  grain,
  looks,
  obstacles,
  mixing,
  lighting,
  exposure,
  pixels,
  satellites,
  imu,
  bias,
  compass,
  metal,
  jitter,
  gaps,
  outliers,
  drift,
  doppler,
  clouds,
  radar,
  false_alarms,
  traffic,
  traffic_echoes,
  ranges,
  waves,
  wheel_sizes
};

/// The stream of one sample, independent of all others. `kind` separates the sensors that share a kind of draw.
inline Random stream(std::uint64_t seed, Draw draw, Duration time, std::uint32_t kind = 0) {
  return Random({.seed = seed, .slot = kind, .stamp = time.count(), .sensor = static_cast<std::uint32_t>(draw)});
}

}  // namespace waymark::simulator
