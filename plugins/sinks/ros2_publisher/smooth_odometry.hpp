// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "waymark/base/time.hpp"
#include "waymark/math/pose.hpp"

namespace waymark::ros2_publisher {

/// The pose in the frame `odom` of REP 105: continuous, though it drifts. The filter's pose jumps when it is corrected;
/// its velocity does not lead to jumps, so it is integrated.
class SmoothOdometry {
 public:
  /// Twist of the base in its own frame [m/s, rad/s] and σ of it (largest axis), at a stamp later than all before.
  void step(Time stamp, const Eigen::Vector3d& v_base, const Eigen::Vector3d& w_base, double v_sigma, double w_sigma);

  const Pose& T_odom_base() const { return T_odom_base_; }
  /// Grow with the way: an error of the velocity lasts, so its integral is their bound.
  double position_sigma_m() const { return position_sigma_m_; }
  double rotation_sigma_rad() const { return rotation_sigma_rad_; }

 private:
  struct Last {
    Time stamp;
    Eigen::Vector3d v_base, w_base;
  };
  std::optional<Last> last_;
  Pose T_odom_base_;
  double position_sigma_m_ = 0.0;
  double rotation_sigma_rad_ = 0.0;
};

}  // namespace waymark::ros2_publisher
