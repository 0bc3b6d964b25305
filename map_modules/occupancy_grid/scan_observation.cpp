// SPDX-License-Identifier: Apache-2.0
#include "scan_observation.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "waymark/error.hpp"

namespace waymark::grid {

ScanObservation observe(const LaserScan& scan, const Pose& T_base_sensor, const ScanSettings& settings) {
  ScanObservation observation;
  observation.p_base_sensor = T_base_sensor.p.head<2>();
  observation.reach = observation.p_base_sensor.norm();
  observation.hits.reserve(scan.ranges_m.size());
  const auto point = [&](double range, double bearing) {
    const Eigen::Vector3d p_sensor(range * std::cos(bearing), range * std::sin(bearing), 0.0);
    const Eigen::Vector2d p_base = (T_base_sensor * p_sensor).head<2>();
    observation.reach = std::max(observation.reach, p_base.norm());
    return Eigen::Vector2f(p_base.cast<float>());
  };
  for (std::size_t k = 0; k < scan.ranges_m.size(); ++k) {
    const auto range = static_cast<double>(scan.ranges_m[k]);
    const double bearing = scan.start_rad + static_cast<double>(k) * scan.step_rad;
    if (!(range >= settings.range_min)) continue;  // NaN, too
    if (range >= settings.no_return) {
      if (settings.no_return_clears > 0.0) observation.clear_to.push_back(point(settings.no_return_clears, bearing));
    } else if (range <= settings.range_max) {
      observation.hits.push_back(point(range, bearing));
    }
  }
  if (observation.hits.empty() && observation.clear_to.empty()) {
    throw DataError("none of the scan's " + std::to_string(scan.ranges_m.size()) +
                    " beams lies between range_min_m and range_max_m");
  }
  return observation;
}

}  // namespace waymark::grid
