// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "scan_settings.hpp"
#include "waymark/map_module.hpp"

namespace waymark::grid {

/// Chooses the scans that are taken: not every one, but one after a distance, an angle or a time. Distance and angle
/// are summed up from scan to scan, as the places lie apart: logs whose times are useless have useless speeds, too.
class ScanSpacing {
 public:
  /// True if this scan is taken; `motion` is the robot's at its stamp. Scans that come late are taken.
  bool takes(Time stamp, const MotionWindow& motion, const ScanSettings& settings);

  void save(OutArchive& out) const;
  void load(InArchive& in);

 private:
  std::optional<Time> last_;                           // scan, taken or not
  std::optional<Time> taken_;                          // the last one that was
  Eigen::Vector3d at_last_ = Eigen::Vector3d::Zero();  // x, y [m], yaw [rad] of the base at the last scan
  double distance_ = 0.0;                              // since the last one that was taken [m]
  double angle_ = 0.0;                                 // [rad]
};

}  // namespace waymark::grid
