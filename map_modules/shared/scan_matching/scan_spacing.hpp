// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "map_modules/shared/scan_matching/scan_settings.hpp"
#include "waymark/interface/map_module.hpp"

namespace waymark::scan_matching {

/// Chooses the scans that are taken: not every one, but one after a distance, an angle or a time.
class ScanSpacing {
 public:
  /// True if this scan is to be taken; `motion` is the robot's at its stamp. Scans that come late are, and all scans of
  /// a robot whose motion only they measure.
  bool is_due(Time stamp, const MotionWindow& motion, const ScanSettings& settings);
  /// It was: the next one is due a distance, an angle or a time from here. Not for a scan of no use.
  void take(Time stamp);

  template <class Archive>
  void serialize(Archive& archive) {
    archive.section("scan_spacing", 1);
    archive(last_, taken_, distance_, angle_);
  }

 private:
  std::optional<Time> last_;   // scan, taken or not
  std::optional<Time> taken_;  // the last one that was
  double distance_ = 0.0;      // since then [m]
  double angle_ = 0.0;         // [rad]
};

}  // namespace waymark::scan_matching
