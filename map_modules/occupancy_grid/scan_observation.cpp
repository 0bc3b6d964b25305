// SPDX-License-Identifier: Apache-2.0
#include "scan_observation.hpp"

#include <algorithm>

#include "scan_beams.hpp"

namespace waymark::grid {

ScanObservation observe(const LaserScan& scan, const Pose& T_base_sensor, const MotionWindow& motion,
                        const ScanSettings& settings) {
  ScanObservation observation;
  observation.p_base_sensor = T_base_sensor.p.head<2>();
  observation.reach = observation.p_base_sensor.norm();
  observation.hits.reserve(scan.ranges_m.size());
  const auto planar = [&](const Eigen::Vector3d& p_base) {
    observation.reach = std::max(observation.reach, p_base.head<2>().norm());
    return Eigen::Vector2f(p_base.head<2>().cast<float>());
  };
  for_beams(
      scan, T_base_sensor, motion, settings, [&](const Eigen::Vector3d& p) { observation.hits.push_back(planar(p)); },
      [&](const Eigen::Vector3d& p) { observation.clear_to.push_back(planar(p)); });
  return observation;
}

}  // namespace waymark::grid
