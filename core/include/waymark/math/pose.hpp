// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "waymark/math/so3.hpp"

namespace waymark {

/// A rigid transform in SE(3). `T_a_b` takes coordinates in b to coordinates in a, so chains cancel visibly:
/// T_a_c = T_a_b * T_b_c. The pose of frame b in frame a is T_a_b.
struct Pose {
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();  ///< rotation part, unit quaternion
  Eigen::Vector3d p = Eigen::Vector3d::Zero();            ///< translation part [m]

  /// A pose in the plane: x, y [m], yaw counter-clockwise [rad]; z, roll and pitch are zero.
  static Pose planar(double x, double y, double yaw) { return {so3::from_rpy(0.0, 0.0, yaw), {x, y, 0.0}}; }

  double yaw() const { return so3::yaw(q); }
  Pose inverse() const { return {q.conjugate(), -(q.conjugate() * p)}; }
  Pose operator*(const Pose& other) const { return {(q * other.q).normalized(), q * other.p + p}; }
  Eigen::Vector3d operator*(const Eigen::Vector3d& point) const { return q * point + p; }
};

}  // namespace waymark
