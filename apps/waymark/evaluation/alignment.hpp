// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>

#include "waymark/math/pose.hpp"

namespace waymark::evaluation {

/// Which rigid motion may be taken out before errors are counted.
enum class Alignment { none, se2, se3 };

/// The rotation about z and translation in the plane, T_to_from, that moves `from` onto `to` with the least sum of
/// squares. Needs two points that are apart on either side; throws Error if not. The spans have the same size.
Pose fit_se2(std::span<const Eigen::Vector2d> from, std::span<const Eigen::Vector2d> to);

/// The rigid motion T_to_from that moves `from` onto `to` with the least sum of squares, without scale (S. Umeyama,
/// "Least-squares estimation of transformation parameters between two point patterns", IEEE TPAMI 13(4), 1991). Needs
/// three points off one line; throws Error if not. The spans have the same size.
Pose fit_se3(std::span<const Eigen::Vector3d> from, std::span<const Eigen::Vector3d> to);

}  // namespace waymark::evaluation
