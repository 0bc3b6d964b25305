// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "waymark/config/config.hpp"
#include "windows.hpp"
#include "world.hpp"

namespace waymark::simulator {

/// The magnetic field: that of the Earth, a dipole in everything that is metal, and what comes and goes: a motor's
/// current, a steel plate under the robot.
class Magnetism {
 public:
  /// Reads the keys of the block `magnetism` (which may be empty). Metal landmarks of `world` become dipoles whose
  /// directions depend on `seed`. Throws ConfigError.
  Magnetism(const Config& config, const World& world, std::uint64_t seed);

  /// Flux density [T] at a point and a time, in the map's frame. `q_map_base` is how the robot stands.
  Eigen::Vector3d field(const Eigen::Vector3d& p_map, const Eigen::Quaterniond& q_map_base, Duration time) const;

 private:
  struct Disturber {
    Eigen::Vector2d p_map;
    double nearest_m;            ///< the field does not grow further inside
    Eigen::Vector3d moment_am2;  ///< dipole moment [A·m²]
  };

  Eigen::Vector3d earth_field_t_;
  std::vector<Disturber> disturbers_;
  Windows disturbances_;
  Eigen::Vector3d disturbance_t_{0.0, 0.0, 0.0};
  bool disturbance_of_robot_ = true;
};

}  // namespace waymark::simulator
