// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "occupancy_grid_settings.hpp"
#include "waymark/map_module.hpp"
#include "waymark/payloads.hpp"

namespace waymark::grid {

/// One scan in the base frame, the same for all particles.
struct ScanObservation final : Observation {
  Eigen::Vector2d p_base_sensor = Eigen::Vector2d::Zero();  ///< where all beams begin [m]
  std::vector<Eigen::Vector2f> hits;                        ///< end points [m]
  std::vector<Eigen::Vector2f> clear_to;                    ///< of beams without return: free up to there [m]
  double reach = 0.0;  ///< of the points and the sensor from the base's origin, at most [m]
};

/// The points of a scan that are used. Throws DataError if there is none, and nothing that is free either.
ScanObservation observe(const LaserScan& scan, const Pose& T_base_sensor, const ScanSettings& settings);

/// Chooses the scans that are taken: not every one, but one after a distance, an angle or a time.
class ScanSpacing {
 public:
  /// True if this scan is taken; `motion` is the robot's at its stamp. Scans that come late are taken.
  bool takes(Time stamp, const MotionWindow& motion, const ScanSettings& settings);

  void save(OutArchive& out) const;
  void load(InArchive& in);

 private:
  std::optional<Time> last_;   // scan, taken or not
  std::optional<Time> taken_;  // the last one that was
  double distance_ = 0.0;      // since then [m]
  double angle_ = 0.0;         // [rad]
};

}  // namespace waymark::grid
