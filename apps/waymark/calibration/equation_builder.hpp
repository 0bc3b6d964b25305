// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "apps/waymark/calibration/equations.hpp"

namespace waymark::calibration {

constexpr double kDegree = std::numbers::pi / 180.0;
const inline Eigen::Matrix2d kQuarterTurn = (Eigen::Matrix2d() << 0.0, -1.0, 1.0, 0.0).finished();

inline Eigen::Matrix2d rotation(double angle) { return Eigen::Rotation2Dd(angle).toRotationMatrix(); }

/// The pose at a time between two knots, on the arc through both, and the smoothed velocity there.
struct Equations::PoseAt {
  Eigen::Index knot = 0;
  double share = 0.0;
  Eigen::Vector2d p;
  double yaw = 0.0;
  Eigen::Vector2d velocity;
  double rate = 0.0;
};

/// Collects rows.
struct Equations::Builder {
  const Eigen::VectorXd& x;
  const Eigen::VectorXd& reference;
  const Eigen::VectorXd& log_levels;
  std::vector<Eigen::Triplet<double>> triplets;
  std::vector<double> residuals;
  Rows rows;
  std::vector<std::pair<Eigen::Index, double>> entries;

  /// The next row belongs to another measurement.
  void measurement() { rows.of.push_back(static_cast<Eigen::Index>(residuals.size())); }
  void entry(Eigen::Index column, double derivative) {
    if (column >= 0 && derivative != 0.0) entries.emplace_back(column, derivative);
  }
  /// The derivative by the pose at a time, applied to both knots, and to a delay of its sensor.
  void pose(const PoseAt& at, const Eigen::Vector3d& gradient, Eigen::Index delay) {
    for (int i = 0; i < 3; ++i) {
      entry(3 * at.knot + i, (1.0 - at.share) * gradient(i));
      entry(3 * at.knot + 3 + i, at.share * gradient(i));
    }
    entry(delay, -gradient.head<2>().dot(at.velocity) - gradient.z() * at.rate);
  }
  void slow(const Slow& slow, double t, double derivative) {
    const auto [node, share] = place(slow, t);
    entry(node, (1.0 - share) * derivative);
    entry(node + 1, share * derivative);
  }
  double slow_value(const Slow& slow, double t) const {
    const auto [node, share] = place(slow, t);
    return (1.0 - share) * x(node) + share * x(node + 1);
  }
  static std::pair<Eigen::Index, double> place(const Slow& slow, double t) {
    const double at = std::clamp((t - slow.begin) / slow.step, 0.0, static_cast<double>(slow.count - 1));
    const auto node = std::min(static_cast<Eigen::Index>(at), slow.count - 2);
    return {slow.first + node, at - static_cast<double>(node)};
  }
  double level(int index) const { return index < 0 ? 1.0 : std::exp(log_levels(index)); }
  /// Ends a row with what was entered since the last one.
  void row(double t, double residual, double sigma, const Rows::Noise& noise) {
    const auto index = static_cast<int>(residuals.size());
    for (const auto& [column, derivative] : entries)
      triplets.emplace_back(index, static_cast<int>(column), derivative / sigma);
    entries.clear();
    residuals.push_back(residual / sigma);
    rows.noise.push_back(noise);
    rows.t.push_back(t);
  }
};

}  // namespace waymark::calibration
