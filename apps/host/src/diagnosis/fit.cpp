// SPDX-License-Identifier: Apache-2.0
#include "fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace waymark::host::diagnosis {

namespace {

constexpr int kIterations = 6;
constexpr double kTukey = 4.685;  // 95 % efficiency for Gaussian residuals (P. J. Huber, 1981)
constexpr int kStretches = 10;    // of the jackknife
constexpr Eigen::Index kLeastRows = 12;

/// Normal equations of some rows.
struct Normal {
  Eigen::MatrixXd H;
  Eigen::VectorXd b;

  Normal(const Rows& rows, const Eigen::VectorXd& w, Eigen::Index from, Eigen::Index count) {
    const auto A = rows.A.middleRows(from, count);
    const auto wA = w.segment(from, count).asDiagonal() * A;
    H = A.transpose() * wA;
    b = wA.transpose() * rows.y.segment(from, count);
  }
};

/// Empty if the columns depend on each other.
Eigen::VectorXd solve(const Eigen::MatrixXd& H, const Eigen::VectorXd& b) {
  // Columns have other units: condition numbers are those of the scaled matrix.
  const Eigen::VectorXd diagonal = H.diagonal();
  if ((diagonal.array() <= 0.0).any() || !diagonal.allFinite()) return {};
  const Eigen::VectorXd scale = diagonal.cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * H * scale.asDiagonal();
  const Eigen::LDLT<Eigen::MatrixXd> factor(scaled);
  if (factor.info() != Eigen::Success || factor.vectorD().minCoeff() < 1e-9) return {};
  return scale.asDiagonal() * factor.solve(scale.asDiagonal() * b);
}

}  // namespace

double median(std::vector<double>& values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

double Fit::sigmas(Eigen::Index i, double expected, double tolerance) const {
  if (!valid) return 0.0;
  const double beyond = std::abs(x(i) - expected) - tolerance;
  return beyond > 0.0 ? beyond / std::max(sigma(i), 1e-12) : 0.0;
}

Fit fit_rows(const Rows& rows, const Eigen::VectorXd& first, double relative) {
  Fit fit;
  const Eigen::Index n = rows.count;
  const Eigen::Index p = rows.A.cols();
  if (n < std::max(kLeastRows, 3 * p)) return fit;
  Eigen::VectorXd w = Eigen::VectorXd::Ones(n);
  Eigen::VectorXd x = first;
  if (x.size() == 0) {
    const Normal all(rows, w, 0, n);
    x = solve(all.H, all.b);
    if (x.size() == 0) return fit;
  }
  std::vector<double> sizes(static_cast<std::size_t>(n));
  double scale = 0.0;
  for (int i = 0; i < kIterations; ++i) {
    const Eigen::VectorXd residuals = rows.y.head(n) - rows.A.topRows(n) * x;
    for (Eigen::Index k = 0; k < n; ++k) sizes[static_cast<std::size_t>(k)] = std::abs(residuals(k));
    scale = std::max(kMadToSigma * median(sizes), 1e-9);
    for (Eigen::Index k = 0; k < n; ++k) {
      const double size = std::max(std::abs(rows.y(k)), std::abs(rows.y(k) - residuals(k)));
      const double u = residuals(k) / (kTukey * std::hypot(scale, relative * size));
      w(k) = std::abs(u) < 1.0 ? (1.0 - u * u) * (1.0 - u * u) : 0.0;
    }
    const Normal weighted(rows, w, 0, n);
    const Eigen::VectorXd next = solve(weighted.H, weighted.b);
    if (next.size() == 0) return fit;
    x = next;
  }
  const Eigen::VectorXd residuals = rows.y.head(n) - rows.A.topRows(n) * x;
  const double weight = w.sum();
  if (weight < static_cast<double>(p) + 3.0) return fit;
  const double variance = (w.array() * residuals.array().square()).sum() / (weight - static_cast<double>(p));
  const Normal all(rows, w, 0, n);
  const Eigen::MatrixXd inverse = all.H.ldlt().solve(Eigen::MatrixXd::Identity(p, p));
  Eigen::VectorXd usual = (variance * inverse.diagonal()).cwiseMax(0.0);

  Eigen::VectorXd jackknife = Eigen::VectorXd::Zero(p);
  int left = 0;
  for (int s = 0; s < kStretches; ++s) {
    const Eigen::Index from = n * s / kStretches;
    const Eigen::Index count = n * (s + 1) / kStretches - from;
    const Normal part(rows, w, from, count);
    const Eigen::VectorXd without = solve(all.H - part.H, all.b - part.b);
    if (without.size() == 0) return fit;  // one stretch alone decides: not a result
    jackknife += (without - x).cwiseAbs2();
    ++left;
  }
  jackknife *= static_cast<double>(left - 1) / left;
  fit.x = x;
  fit.sigma = usual.cwiseMax(jackknife).cwiseSqrt();
  fit.weights = w;
  fit.residual = std::sqrt(std::max(variance, 0.0));
  fit.kept = weight / static_cast<double>(n);
  fit.valid = fit.sigma.allFinite();
  return fit;
}

SlopeBounds slope_bounds(const Rows& rows, const Fit& fit, Eigen::Index slope) {
  const Eigen::Index n = rows.count;
  const Eigen::Index p = rows.A.cols();
  Eigen::VectorXd x = rows.A.col(slope).head(n);
  Eigen::VectorXd y = rows.y.head(n);
  const Eigen::VectorXd& w = fit.weights;
  if (p > 1) {
    Eigen::MatrixXd others(n, p - 1);
    for (Eigen::Index c = 0, to = 0; c < p; ++c) {
      if (c != slope) others.col(to++) = rows.A.col(c).head(n);
    }
    const Eigen::MatrixXd H = others.transpose() * w.asDiagonal() * others;
    const auto factor = H.colPivHouseholderQr();
    x -= others * factor.solve(others.transpose() * (w.asDiagonal() * x));
    y -= others * factor.solve(others.transpose() * (w.asDiagonal() * y));
  }
  const double xx = (w.array() * x.array().square()).sum();
  const double yy = (w.array() * y.array().square()).sum();
  const double xy = (w.array() * x.array() * y.array()).sum();
  SlopeBounds bounds;
  if (!(xx > 0.0) || !(yy > 0.0) || xy == 0.0) return bounds;
  const double forward = xy / xx;
  const double backward = yy / xy;
  bounds.low = std::min(forward, backward);
  bounds.high = std::max(forward, backward);
  bounds.correlation2 = xy * xy / (xx * yy);
  bounds.spread_x = std::sqrt(xx / w.sum());
  return bounds;
}

}  // namespace waymark::host::diagnosis
