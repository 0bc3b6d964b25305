// SPDX-License-Identifier: Apache-2.0
#include "scan_observation.hpp"

#include <algorithm>

#include "scan_beams.hpp"

namespace waymark::grid {

ScanObservation observe(const LaserScan& scan, const Pose& T_base_sensor, const ScanSettings& settings) {
  ScanObservation observation;
  observation.p_base_sensor = T_base_sensor.p.head<2>();
  observation.reach = observation.p_base_sensor.norm();
  observation.hits.reserve(scan.ranges_m.size());
  const auto in_base = [&](const Eigen::Vector3d& p_sensor) {
    const Eigen::Vector2d p_base = (T_base_sensor * p_sensor).head<2>();
    observation.reach = std::max(observation.reach, p_base.norm());
    return Eigen::Vector2f(p_base.cast<float>());
  };
  for_beams(
      scan, settings, [&](const Eigen::Vector3d& p) { observation.hits.push_back(in_base(p)); },
      [&](const Eigen::Vector3d& p) { observation.clear_to.push_back(in_base(p)); });
  return observation;
}

}  // namespace waymark::grid
