// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/evaluation/alignment.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <cassert>
#include <cmath>

#include "waymark/base/error.hpp"

namespace waymark::evaluation {
namespace {

// Below this share of the spread a direction counts as absent: the rotation about it would be rounding noise.
constexpr double kDegenerate = 1e-9;

template <class Vector>
Vector mean_of(std::span<const Vector> points) {
  Vector sum = Vector::Zero();
  for (const Vector& point : points) sum += point;
  return sum / static_cast<double>(points.size());
}

}  // namespace

Pose fit_se2(std::span<const Eigen::Vector2d> from, std::span<const Eigen::Vector2d> to) {
  assert(from.size() == to.size());
  if (from.size() < 2) {
    throw Error(fmt::format("alignment se2: {} common points, expected at least 2", from.size()));
  }
  const Eigen::Vector2d from_mean = mean_of(from);
  const Eigen::Vector2d to_mean = mean_of(to);
  double dot = 0.0;
  double cross = 0.0;
  double spread = 0.0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const Eigen::Vector2d a = from[i] - from_mean;
    const Eigen::Vector2d b = to[i] - to_mean;
    dot += a.dot(b);
    cross += a.x() * b.y() - a.y() * b.x();
    spread += 0.5 * (a.squaredNorm() + b.squaredNorm());
  }
  if (std::hypot(dot, cross) <= kDegenerate * spread || spread == 0.0) {
    throw Error("alignment se2: the points do not determine a rotation (all in one place?); use --align none");
  }
  const double yaw = std::atan2(cross, dot);
  const Eigen::Vector2d shift = to_mean - Eigen::Rotation2Dd(yaw) * from_mean;
  return Pose::planar(shift.x(), shift.y(), yaw);
}

Pose fit_se3(std::span<const Eigen::Vector3d> from, std::span<const Eigen::Vector3d> to) {
  assert(from.size() == to.size());
  if (from.size() < 3) {
    throw Error(fmt::format("alignment se3: {} common points, expected at least 3", from.size()));
  }
  const Eigen::Vector3d from_mean = mean_of(from);
  const Eigen::Vector3d to_mean = mean_of(to);
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  double spread = 0.0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const Eigen::Vector3d a = from[i] - from_mean;
    const Eigen::Vector3d b = to[i] - to_mean;
    covariance += b * a.transpose();
    spread += 0.5 * (a.squaredNorm() + b.squaredNorm());
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  // Two directions determine the third by handedness.
  if (!(svd.singularValues()[1] > kDegenerate * spread)) {
    throw Error("alignment se3: the points lie on one line and do not determine a rotation; use --align se2");
  }
  Eigen::Vector3d signs = Eigen::Vector3d::Ones();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0) signs.z() = -1.0;
  const Eigen::Matrix3d R = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  return {Eigen::Quaterniond(R).normalized(), to_mean - R * from_mean};
}

}  // namespace waymark::evaluation
