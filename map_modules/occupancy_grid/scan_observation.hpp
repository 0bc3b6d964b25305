// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "scan_settings.hpp"
#include "waymark/interface/map_module.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::grid {

/// One scan in the base frame, the same for all particles.
struct ScanObservation final : Observation {
  Eigen::Vector2d p_base_sensor = Eigen::Vector2d::Zero();  ///< where all beams begin [m]
  std::vector<Eigen::Vector2f> hits;                        ///< end points [m]
  std::vector<Eigen::Vector2f> clear_to;                    ///< of beams without return: free up to there [m]
  double reach = 0.0;  ///< of the points and the sensor from the base's origin, at most [m]
};

/// The points of a scan that are used, seen from where the base was at the stamp. Throws DataError if there is none,
/// and nothing that is free either.
ScanObservation observe(const LaserScan& scan, const Pose& T_base_sensor, const MotionWindow& motion,
                        const ScanSettings& settings);

}  // namespace waymark::grid
