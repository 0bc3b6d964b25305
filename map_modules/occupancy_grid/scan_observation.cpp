// SPDX-License-Identifier: Apache-2.0
#include "map_modules/occupancy_grid/scan_observation.hpp"

namespace waymark::occupancy_grid {

ScanObservation observe(const LaserScan& scan, const Pose& T_base_sensor, const MotionWindow& motion,
                        const scan_matching::ScanSettings& settings) {
  return ScanObservation(scan_matching::scan_points<2>(scan, T_base_sensor, motion, settings));
}

}  // namespace waymark::occupancy_grid
