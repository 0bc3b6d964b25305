// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

#include "map_modules/feature_map/feature_observation.hpp"

namespace waymark::feature_map {

/// One detection against one landmark: ν = z_map − θ and its Jacobian by the pose, D = 2 (position) or 3 (with radius).
/// The detection is turned into the map frame, so the landmark's Jacobian is the identity.
template <int D>
struct DetectionModel {
  using Vector = Eigen::Matrix<double, D, 1>;
  using Matrix = Eigen::Matrix<double, D, D>;
  using PoseJacobian = Eigen::Matrix<double, D, 3>;

  Vector z;  ///< detection in the map frame, seen from the pose
  Matrix R;  ///< its noise in the map frame
  Eigen::Vector2d p_map_base;

  /// `pose`: x [m], y [m], yaw [rad].
  DetectionModel(const Detection& detection, const Eigen::Vector3d& pose) : p_map_base(pose.head<2>()) {
    const Eigen::Matrix2d turn = Eigen::Rotation2Dd(pose.z()).toRotationMatrix();
    z.template head<2>() = p_map_base + turn * detection.xyr.head<2>();
    R.template topLeftCorner<2, 2>() = turn * detection.R.topLeftCorner<2, 2>() * turn.transpose();
    if constexpr (D == 3) {
      z[2] = detection.xyr.z();
      R.template topRightCorner<2, 1>() = turn * detection.R.topRightCorner<2, 1>();
      R.template bottomLeftCorner<1, 2>() = R.template topRightCorner<2, 1>().transpose();
      R(2, 2) = detection.R(2, 2);
    }
  }

  /// ∂h/∂(x, y, yaw) for a landmark or detection at `p_map`.
  PoseJacobian jacobian(const Eigen::Vector2d& p_map) const {
    const Eigen::Vector2d d = p_map - p_map_base;
    PoseJacobian H = PoseJacobian::Zero();
    H(0, 0) = -1.0;
    H(1, 1) = -1.0;
    H(0, 2) = d.y();
    H(1, 2) = -d.x();
    return H;
  }
};

/// log N(ν; 0, S) out of νᵀ S⁻¹ ν and |S|.
template <int D>
double log_normal(double squared_mahalanobis, double determinant) {
  constexpr double kLogTwoPi = 1.8378770664093453;
  return -0.5 * (squared_mahalanobis + std::log(determinant) + D * kLogTwoPi);
}

}  // namespace waymark::feature_map
