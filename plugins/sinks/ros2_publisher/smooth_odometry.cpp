// SPDX-License-Identifier: Apache-2.0
#include "smooth_odometry.hpp"

#include <algorithm>

#include "waymark/math/so3.hpp"

namespace waymark::ros2_publisher {

void SmoothOdometry::step(Time stamp, const Eigen::Vector3d& v_base, const Eigen::Vector3d& w_base, double v_sigma,
                          double w_sigma) {
  // After a gap nobody knows what the robot did.
  constexpr double kLongestStep = 1.0;
  if (last_) {
    const double dt = std::clamp(to_seconds(stamp - last_->stamp), 0.0, kLongestStep);
    const Eigen::Vector3d v = 0.5 * (last_->v_base + v_base);
    const Eigen::Vector3d w = 0.5 * (last_->w_base + w_base);
    T_odom_base_ = T_odom_base_ * Pose{so3::exp(w * dt), so3::left_jacobian(w * dt) * v * dt};
    position_sigma_m_ += dt * (v_sigma + v.norm() * rotation_sigma_rad_);
    rotation_sigma_rad_ += dt * w_sigma;
  }
  last_ = {stamp, v_base, w_base};
}

}  // namespace waymark::ros2_publisher
