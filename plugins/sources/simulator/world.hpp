// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <vector>

#include "waymark/config.hpp"

namespace waymark::simulator {

/// A vertical cylinder as a horizontal plane cuts it.
struct Cylinder {
  Eigen::Vector2d center;  ///< in the map [m]
  double radius_m;
};

/// What stands around the robot.
class World {
 public:
  static constexpr double kNothing = std::numeric_limits<double>::infinity();

  explicit World(std::vector<Cylinder> cylinders) : cylinders_(std::move(cylinders)) {}

  const std::vector<Cylinder>& cylinders() const { return cylinders_; }

  /// Distance [m] from `origin` to the first surface in direction `angle_rad` (map frame, counter-clockwise from east),
  /// or `kNothing`. From inside a cylinder its wall is seen.
  double cast(const Eigen::Vector2d& origin, double angle_rad) const;

 private:
  std::vector<Cylinder> cylinders_;
};

/// The block `landmarks`: an explicit list, or a number of cylinders drawn at random that keep clear of `path` and of
/// each other. Throws ConfigError, also if they do not fit.
World read_world(const Config& config, const std::vector<Eigen::Vector2d>& path, std::uint64_t default_seed);

}  // namespace waymark::simulator
