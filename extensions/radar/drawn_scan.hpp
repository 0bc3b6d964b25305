// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "waymark/interface/payloads.hpp"
#include "waymark/math/random.hpp"

namespace waymark::radar {

/// A scan as a test wants it.
struct DrawnScan {
  Eigen::Vector3d v = Eigen::Vector3d::Zero();  ///< of the radar, in its frame
  std::size_t still = 100;                      ///< targets that stand still
  std::size_t moving = 0;                       ///< targets with the velocity `v_moving` over ground
  Eigen::Vector3d v_moving = Eigen::Vector3d::Zero();
  double azimuth_max_rad = 1.0;
  double elevation_max_rad = 0.0;
  double noise_mps = 0.0;  ///< of radial velocities
};

/// Targets of that scan, those that stand still first.
inline std::vector<RadarTargets::One> draw(const DrawnScan& scan, Random random) {
  std::vector<RadarTargets::One> targets(scan.still + scan.moving);
  for (std::size_t i = 0; i < targets.size(); ++i) {
    RadarTargets::One& one = targets[i];
    one.range_m = 5.0 + 50.0 * random.uniform();
    one.azimuth_rad = scan.azimuth_max_rad * (2.0 * random.uniform() - 1.0);
    one.elevation_rad = scan.elevation_max_rad * (2.0 * random.uniform() - 1.0);
    const Eigen::Vector3d ray(std::cos(one.elevation_rad) * std::cos(one.azimuth_rad),
                              std::cos(one.elevation_rad) * std::sin(one.azimuth_rad), std::sin(one.elevation_rad));
    const Eigen::Vector3d relative =
        i < scan.still ? Eigen::Vector3d(-scan.v) : Eigen::Vector3d(scan.v_moving - scan.v);
    one.radial_mps = ray.dot(relative) + scan.noise_mps * random.normal();
  }
  return targets;
}

}  // namespace waymark::radar
