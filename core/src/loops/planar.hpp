// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "waymark/math/pose.hpp"
#include "waymark/math/so3.hpp"

/// Poses in the plane as (x [m], y [m], yaw [rad]), T_a_b, and their relations.
namespace waymark::loops {

inline Eigen::Matrix2d rotation(double yaw) {
  const double c = std::cos(yaw);
  const double s = std::sin(yaw);
  return (Eigen::Matrix2d() << c, -s, s, c).finished();
}

/// The same for (x, y, yaw), whose yaw it leaves alone.
inline Eigen::Matrix3d turn(double yaw) {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  R.topLeftCorner<2, 2>() = rotation(yaw);
  return R;
}

/// a − b, by components; not a pose.
inline Eigen::Vector3d difference(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return {a.x() - b.x(), a.y() - b.y(), so3::wrap(a.z() - b.z())};
}

/// On the straight way from `a` to `b`, `share` from 0 to 1.
inline Eigen::Vector3d interpolate(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double share) {
  const Eigen::Vector3d d = difference(b, a);
  return {a.x() + share * d.x(), a.y() + share * d.y(), so3::wrap(a.z() + share * d.z())};
}

/// A turn counts as the way of a point so far away, where ways are measured [m].
constexpr double kArm = 0.5;

/// Variance of the position, of a covariance of (x, y, yaw) [m²].
inline double position_variance(const Eigen::Matrix3d& P) { return P(0, 0) + P(1, 1); }

/// T_a_c of T_a_b and T_b_c.
inline Eigen::Vector3d compose(const Eigen::Vector3d& ab, const Eigen::Vector3d& bc) {
  Eigen::Vector3d ac;
  ac.head<2>() = ab.head<2>() + rotation(ab.z()) * bc.head<2>();
  ac.z() = so3::wrap(ab.z() + bc.z());
  return ac;
}

/// T_b_c of T_a_b and T_a_c.
inline Eigen::Vector3d between(const Eigen::Vector3d& ab, const Eigen::Vector3d& ac) {
  Eigen::Vector3d bc;
  bc.head<2>() = rotation(ab.z()).transpose() * (ac.head<2>() - ab.head<2>());
  bc.z() = so3::wrap(ac.z() - ab.z());
  return bc;
}

inline Eigen::Vector3d inverse(const Eigen::Vector3d& ab) { return between(ab, Eigen::Vector3d::Zero()); }

/// The planar part of a pose.
inline Eigen::Vector3d planar(const Pose& pose) { return {pose.p.x(), pose.p.y(), pose.yaw()}; }

/// A relation of two poses with its noise, N(z, P), both in the axes of the first.
struct Relation {
  Eigen::Vector3d z = Eigen::Vector3d::Zero();
  Eigen::Matrix3d P = Eigen::Matrix3d::Zero();
};

/// The relation to `bc`'s second pose; errors of both are independent (R. Smith, P. Cheeseman, 1986).
inline Relation compose(const Relation& ab, const Relation& bc) {
  Eigen::Matrix3d of_first = Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d of_second = turn(ab.z.z());
  const Eigen::Vector2d arm = of_second.topLeftCorner<2, 2>() * bc.z.head<2>();
  of_first(0, 2) = -arm.y();
  of_first(1, 2) = arm.x();
  return {compose(ab.z, bc.z), of_first * ab.P * of_first.transpose() + of_second * bc.P * of_second.transpose()};
}

/// The relation in the other direction.
inline Relation inverse(const Relation& ab) {
  // ba = −Rᵀ ab: its error is −Rᵀ (δt + δyaw × …), in the axes of the second.
  const Eigen::Vector3d z = inverse(ab.z);
  Eigen::Matrix3d J = -Eigen::Matrix3d::Identity();
  J.topLeftCorner<2, 2>() = -rotation(ab.z.z()).transpose();
  J(0, 2) = z.y();
  J(1, 2) = -z.x();
  return {z, J * ab.P * J.transpose()};
}

}  // namespace waymark::loops
