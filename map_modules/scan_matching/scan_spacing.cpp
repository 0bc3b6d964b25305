// SPDX-License-Identifier: Apache-2.0
#include "scan_spacing.hpp"

#include <cmath>

#include "waymark/error.hpp"
#include "waymark/so3.hpp"

namespace waymark::grid {

bool ScanSpacing::takes(Time stamp, const MotionWindow& motion, const ScanSettings& settings) {
  if (last_ && stamp < *last_) return true;
  const Eigen::Vector3d at(motion.T_map_base.p.x(), motion.T_map_base.p.y(), motion.T_map_base.yaw());
  if (last_) {
    distance_ += (at - at_last_).head<2>().norm();
    angle_ += std::abs(so3::wrap(at.z() - at_last_.z()));
  }
  last_ = stamp;
  at_last_ = at;
  const bool is_due = settings.update_after > Duration::zero() && taken_ && stamp - *taken_ >= settings.update_after;
  if (taken_ && !is_due && distance_ < settings.update_distance && angle_ < settings.update_angle) return false;
  taken_ = stamp;
  distance_ = angle_ = 0.0;
  return true;
}

void ScanSpacing::save(OutArchive& out) const {
  out.section("scan_spacing", 2);
  out.value(last_);
  out.value(taken_);
  out.value(at_last_);
  out.value(distance_);
  out.value(angle_);
}

void ScanSpacing::load(InArchive& in) {
  if (in.section("scan_spacing", 2) < 2) throw DataError("the checkpoint is of an older kind");
  in.value(last_);
  in.value(taken_);
  in.value(at_last_);
  in.value(distance_);
  in.value(angle_);
}

}  // namespace waymark::grid
