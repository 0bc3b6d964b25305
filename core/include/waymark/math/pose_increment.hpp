// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <numbers>

#include "waymark/interface/payloads.hpp"

namespace waymark {

/// Increment of odometry given as poses: `end` in the frame of `begin`, both (x [m], y [m], yaw [rad]).
inline PoseIncrement pose_increment(const Eigen::Vector3d& begin, const Eigen::Vector3d& end, double interval_s) {
  const double dx = end.x() - begin.x();
  const double dy = end.y() - begin.y();
  const double c = std::cos(begin.z());
  const double s = std::sin(begin.z());
  PoseIncrement increment;
  increment.interval_s = interval_s;
  increment.x_m = c * dx + s * dy;
  increment.y_m = c * dy - s * dx;
  increment.yaw_rad = std::remainder(end.z() - begin.z(), 2.0 * std::numbers::pi);
  return increment;
}

}  // namespace waymark
