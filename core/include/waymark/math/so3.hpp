// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "waymark/base/api.hpp"

/// The rotation group SO(3) as free functions. Notation after J. Solà, J. Deray, D. Atchuthan, "A micro Lie theory for
/// state estimation in robotics", 2018.
namespace waymark::so3 {

/// The cross-product matrix: skew(a) b = a × b.
WAYMARK_API Eigen::Matrix3d skew(const Eigen::Vector3d& a);

/// Exp: rotation vector [rad] to unit quaternion (Solà 2018, eq. 132).
WAYMARK_API Eigen::Quaterniond exp(const Eigen::Vector3d& theta);

/// Log: unit quaternion to the shortest rotation vector, |theta| <= pi [rad] (Solà 2018, eq. 133).
WAYMARK_API Eigen::Vector3d log(const Eigen::Quaterniond& q);

/// Left Jacobian: Exp(theta + d) ≈ Exp(J_l(theta) d) Exp(theta) (Solà 2018, eq. 145).
WAYMARK_API Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& theta);

/// d(J_l(theta) a)/d(theta), 3 × 3: how the translation of a screw motion depends on its rotation.
WAYMARK_API Eigen::Matrix3d left_jacobian_times_vector_derivative(const Eigen::Vector3d& theta,
                                                                  const Eigen::Vector3d& a);

/// Heading of the x axis, counter-clockwise from the map's x axis (east) [rad], in (-pi, pi].
WAYMARK_API double yaw(const Eigen::Quaterniond& q_map_base);

/// R = Rz(yaw) Ry(pitch) Rx(roll) [rad].
WAYMARK_API Eigen::Quaterniond from_rpy(double roll, double pitch, double yaw);

/// (roll, pitch, yaw) [rad] of R = Rz(yaw) Ry(pitch) Rx(roll).
WAYMARK_API Eigen::Vector3d to_rpy(const Eigen::Quaterniond& q);

/// The equal angle in (-pi, pi] [rad].
WAYMARK_API double wrap(double angle);

}  // namespace waymark::so3
