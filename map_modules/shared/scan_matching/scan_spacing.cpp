// SPDX-License-Identifier: Apache-2.0
#include "map_modules/shared/scan_matching/scan_spacing.hpp"

#include <cmath>

namespace waymark::scan_matching {

bool ScanSpacing::is_due(Time stamp, const MotionWindow& motion, const ScanSettings& settings) {
  if (last_ && stamp < *last_) return true;
  const double dt = last_ ? to_seconds(stamp - *last_) : 0.0;
  distance_ += motion.v_base.head<2>().norm() * dt;
  angle_ += std::abs(motion.w_base.z()) * dt;
  last_ = stamp;
  const bool is_late = settings.update_after > Duration::zero() && taken_ && stamp - *taken_ >= settings.update_after;
  return !motion.is_measured || !taken_ || is_late || distance_ >= settings.update_distance ||
         angle_ >= settings.update_angle;
}

void ScanSpacing::take(Time stamp) {
  if (last_ && stamp < *last_) return;
  taken_ = stamp;
  distance_ = angle_ = 0.0;
}

}  // namespace waymark::scan_matching
