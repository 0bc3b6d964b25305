// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

/// Errors of a pose in the plane as a motion ξ = (ρ, φ) of the whole map: (δp, δφ) = T(p) ξ with δp = ρ + φ × p. It is
/// the same for all poses that are wrong together, wherever they are (A. Barrau, S. Bonnabel, 2015).
namespace waymark::loops {

/// T(p): from (ρ, φ) to (δx, δy, δyaw) at `p` [m].
inline Eigen::Matrix3d error_of_twist(const Eigen::Vector2d& p) {
  Eigen::Matrix3d T = Eigen::Matrix3d::Identity();
  T(0, 2) = -p.y();
  T(1, 2) = p.x();
  return T;
}

/// Its inverse.
inline Eigen::Matrix3d twist_of_error(const Eigen::Vector2d& p) { return error_of_twist(-p); }

}  // namespace waymark::loops
