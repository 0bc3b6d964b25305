// SPDX-License-Identifier: Apache-2.0
#include "estimation/heading_fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace waymark::estimation {

namespace {

constexpr int kHeadings = 720;  // of the posterior on the circle

/// Covariance of fixes and dead reckoning together. The errors of a fix have no direction, so that it is the same in
/// every rotated frame.
Eigen::MatrixXd covariance_of(const std::vector<ReckonedFix>& fixes, const Eigen::MatrixXd& reckoned) {
  Eigen::MatrixXd joint = reckoned;
  const auto n = static_cast<Eigen::Index>(fixes.size());
  for (Eigen::Index i = 0; i < n; ++i) {
    const ReckonedFix& a = fixes[static_cast<std::size_t>(i)];
    joint.block<2, 2>(2 * i, 2 * i).diagonal().array() += a.sigma_m * a.sigma_m;
    for (Eigen::Index j = 0; j < n; ++j) {
      const ReckonedFix& b = fixes[static_cast<std::size_t>(j)];
      if (a.sensor != b.sensor || a.slow_tau_s <= 0.0 || b.slow_tau_s <= 0.0) continue;
      const double apart = std::abs(to_seconds(a.stamp - b.stamp));
      joint.block<2, 2>(2 * i, 2 * j).diagonal().array() +=
          a.slow_sigma_m * b.slow_sigma_m * std::exp(-apart / std::max(a.slow_tau_s, b.slow_tau_s));
    }
  }
  return joint;
}

/// χ² of a heading as a quadratic form in u = (cos, sin): uᵀ M u − 2 bᵀ u + c, the translation eliminated.
struct Misfit {
  Eigen::Matrix2d M;
  Eigen::Vector2d b;
  double c = 0.0;

  double at(double yaw) const {
    const Eigen::Vector2d u(std::cos(yaw), std::sin(yaw));
    return u.dot(M * u) - 2.0 * b.dot(u) + c;
  }
  double curvature(double yaw) const {
    const Eigen::Vector2d u(std::cos(yaw), std::sin(yaw));
    const Eigen::Vector2d du(-u.y(), u.x());
    return 2.0 * (du.dot(M * du) - u.dot(M * u) + b.dot(u));
  }
};

/// Residual of point i: Rᵀ(yaw) z_i − t − a_i, with z_i the fix and a_i dead reckoning.
std::optional<Misfit> misfit_of(const std::vector<ReckonedFix>& fixes, const Eigen::MatrixXd& joint) {
  const auto n = static_cast<Eigen::Index>(fixes.size());
  Eigen::MatrixXd Z(2 * n, 2);
  Eigen::MatrixXd T(2 * n, 2);
  Eigen::VectorXd a(2 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const ReckonedFix& fix = fixes[static_cast<std::size_t>(i)];
    const Eigen::Vector2d z = fix.p_map - fixes.front().p_map;  // far from the map's origin digits would be lost
    Z.block<2, 2>(2 * i, 0) << z.x(), z.y(), z.y(), -z.x();
    T.block<2, 2>(2 * i, 0).setIdentity();
    a.segment<2>(2 * i) = fix.p_local;
  }
  const Eigen::LLT<Eigen::MatrixXd> factor(joint);
  if (factor.info() != Eigen::Success || !Z.allFinite() || !a.allFinite() || !joint.allFinite()) return std::nullopt;
  factor.matrixL().solveInPlace(Z);
  factor.matrixL().solveInPlace(T);
  factor.matrixL().solveInPlace(a);
  const Eigen::Matrix2d TtT_inverse = (T.transpose() * T).inverse();
  Z -= (T * (TtT_inverse * (T.transpose() * Z))).eval();
  a -= (T * (TtT_inverse * (T.transpose() * a))).eval();
  return Misfit{Z.transpose() * Z, Z.transpose() * a, a.squaredNorm()};
}

double best_heading(const Misfit& misfit) {
  const double step = 2.0 * std::numbers::pi / kHeadings;
  double best = 0.0;
  for (int k = 1; k < kHeadings; ++k) {
    if (misfit.at(k * step) < misfit.at(best)) best = k * step;
  }
  double low = best - step;
  double high = best + step;
  for (int k = 0; k < 60; ++k) {
    const double third = (high - low) / 3.0;
    if (misfit.at(low + third) < misfit.at(high - third)) {
      high -= third;
    } else {
      low += third;
    }
  }
  return 0.5 * (low + high);
}

}  // namespace

std::optional<HeadingFit> fit_heading(const std::vector<ReckonedFix>& fixes, const Eigen::MatrixXd& reckoned) {
  if (fixes.size() < 2) return std::nullopt;
  const std::optional<Misfit> misfit = misfit_of(fixes, covariance_of(fixes, reckoned));
  if (!misfit) return std::nullopt;

  const double best = best_heading(*misfit);
  const double least = misfit->at(best);
  // Two of the unknowns are the translation, one is the heading.
  const double freedom = 2.0 * static_cast<double>(fixes.size()) - 3.0;
  const double inflation = std::max(1.0, least / freedom);
  double weights = 0.0;
  double square = 0.0;
  for (int k = 0; k < kHeadings; ++k) {
    const int steps = k - kHeadings / 2;
    const double off = steps * 2.0 * std::numbers::pi / kHeadings;
    const double weight = std::exp(-0.5 * (misfit->at(best + off) - least) / inflation);
    weights += weight;
    square += weight * off * off;
  }
  HeadingFit fit;
  fit.yaw = std::remainder(best, 2.0 * std::numbers::pi);
  fit.sigma = std::sqrt(square / weights);
  // A posterior that is narrower than the grid has the width that its curvature gives.
  const double curvature = misfit->curvature(best);
  if (curvature > 0.0) fit.sigma = std::max(fit.sigma, std::sqrt(2.0 * inflation / curvature));
  if (!std::isfinite(fit.yaw) || !std::isfinite(fit.sigma)) return std::nullopt;
  return fit;
}

}  // namespace waymark::estimation
