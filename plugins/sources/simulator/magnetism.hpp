// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "waymark/config.hpp"
#include "world.hpp"

namespace waymark::simulator {

/// The magnetic field: that of the Earth, and a dipole in everything that is metal.
class Magnetism {
 public:
  /// Reads the keys of the block `magnetism` (which may be empty). Metal landmarks of `world` become dipoles whose
  /// directions depend on `seed`. Throws ConfigError.
  Magnetism(const Config& config, const World& world, std::uint64_t seed);

  /// Flux density [T] at a point, in the map's frame.
  Eigen::Vector3d field(const Eigen::Vector3d& p_map) const;

 private:
  struct Disturber {
    Eigen::Vector2d p_map;
    double nearest_m;            ///< the field does not grow further inside
    Eigen::Vector3d moment_am2;  ///< dipole moment [A·m²]
  };

  Eigen::Vector3d earth_field_t_;
  std::vector<Disturber> disturbers_;
};

}  // namespace waymark::simulator
