// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "waymark/base/time.hpp"
#include "waymark/config/config.hpp"

namespace waymark::simulator {

/// Things that drive about, each to and fro on a straight line at constant speed. Radars see them; they hide nothing,
/// and nobody runs into them.
class Traffic {
 public:
  /// One of them at one time.
  struct Thing {
    Eigen::Vector2d p_map;  ///< its middle [m]
    Eigen::Vector2d v_map;  ///< its velocity [m/s]
  };
  static constexpr double kRadius = 1.0;  ///< of each [m]

  /// Reads `count`, `area_m` and `speed_mps`; none without `count`. Throws ConfigError.
  Traffic(const Config& config, std::uint64_t seed);

  /// Where they all are.
  std::vector<Thing> at(Duration time) const;

 private:
  struct Line {
    Eigen::Vector2d from;
    Eigen::Vector2d to;
    double speed_mps;
    double start_m;  ///< driven before the start
  };
  std::vector<Line> lines_;
};

}  // namespace waymark::simulator
