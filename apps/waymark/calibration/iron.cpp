// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/calibration/iron.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace waymark::calibration {

namespace {

constexpr std::size_t kFewestFields = 50;
constexpr std::size_t kIronBlocks = 20;  // of time, for the scatter of the scores
constexpr double kSpatial = 0.3;         // least by largest spread of the readings: below, the robot stayed level
constexpr double kIronHuber = 2.576;     // 99 % of Gaussian residuals
constexpr double kNormalMad = 1.4826;    // σ by the median of the absolute values

/// Places of a symmetric matrix in a vector of parameters, after the centre.
struct Symmetric {
  int d;
  int size() const { return d * (d + 1) / 2; }
  template <class Visitor>
  void visit(Visitor&& visitor) const {
    int k = d;
    for (int i = 0; i < d; ++i) {
      for (int j = i; j < d; ++j) visitor(i, j, k++);
    }
  }
};

/// Centre c and matrix W with |W (p − c)| = 1.
struct Ellipsoid {
  Eigen::VectorXd center;
  Eigen::MatrixXd W;
};

/// pᵀ Q p + 2 uᵀ p = 1 by linear least squares; nothing if that is no ellipsoid.
std::optional<Ellipsoid> algebraic_ellipsoid(const Eigen::MatrixXd& points) {
  const int d = static_cast<int>(points.cols());
  const Symmetric symmetric{d};
  Eigen::MatrixXd design(points.rows(), d + symmetric.size());
  design.leftCols(d) = 2.0 * points;
  symmetric.visit(
      [&](int i, int j, int k) { design.col(k) = (i == j ? 1.0 : 2.0) * points.col(i).cwiseProduct(points.col(j)); });
  const Eigen::VectorXd solution =
      (design.transpose() * design).ldlt().solve(design.transpose() * Eigen::VectorXd::Ones(points.rows()));
  Eigen::MatrixXd Q(d, d);
  symmetric.visit([&](int i, int j, int k) { Q(i, j) = Q(j, i) = solution(k); });
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(Q);
  if (!solution.allFinite() || !(eigen.eigenvalues()(0) > 0.0)) return std::nullopt;
  Ellipsoid found;
  found.center = -Q.ldlt().solve(solution.head(d));
  const double size = 1.0 + found.center.dot(Q * found.center);
  found.W = eigen.operatorSqrt() / std::sqrt(size);
  return found;
}

/// Residuals (distances, to first order) and their Jacobian at an ellipsoid.
void linearize_ellipsoid(const Eigen::MatrixXd& points, const Ellipsoid& at, Eigen::VectorXd& residual,
                         Eigen::MatrixXd& J) {
  const int d = static_cast<int>(points.cols());
  const Symmetric symmetric{d};
  residual.resize(points.rows());
  J.resize(points.rows(), d + symmetric.size());
  for (Eigen::Index row = 0; row < points.rows(); ++row) {
    const Eigen::VectorXd q = points.row(row).transpose() - at.center;
    const Eigen::VectorXd w = at.W * q;
    const double s = std::max(w.norm(), 1e-9);
    const Eigen::VectorXd gradient = at.W * w / s;
    const double steepness = gradient.norm();
    residual(row) = (s - 1.0) / steepness;
    J.row(row).head(d) = -gradient.transpose() / steepness;
    symmetric.visit(
        [&](int i, int j, int k) { J(row, k) = (i == j ? w(i) * q(i) : w(i) * q(j) + w(j) * q(i)) / (s * steepness); });
  }
}

Eigen::VectorXd ellipsoid_weights(const Eigen::VectorXd& residual, double& sigma) {
  std::vector<double> sizes(residual.data(), residual.data() + residual.size());
  for (double& size : sizes) size = std::abs(size);
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::ranges::nth_element(sizes, middle);
  sigma = std::max(kNormalMad * *middle, 1e-9);
  return residual.unaryExpr([&](double r) { return std::min(1.0, kIronHuber * sigma / std::max(std::abs(r), 1e-12)); });
}

/// The larger one of the usual covariance's σ and of that by the scores of blocks of time (White, 1982).
Eigen::VectorXd ellipsoid_sigmas(const Eigen::MatrixXd& J, const Eigen::VectorXd& residual,
                                 const Eigen::VectorXd& weight, double sigma) {
  const Eigen::MatrixXd inverse = (J.transpose() * weight.asDiagonal() * J).inverse();
  Eigen::MatrixXd scores = Eigen::MatrixXd::Zero(J.cols(), J.cols());
  for (std::size_t block = 0; block < kIronBlocks; ++block) {
    const auto begin = static_cast<Eigen::Index>(block * static_cast<std::size_t>(J.rows()) / kIronBlocks);
    const auto end = static_cast<Eigen::Index>((block + 1) * static_cast<std::size_t>(J.rows()) / kIronBlocks);
    const Eigen::VectorXd weighted =
        residual.segment(begin, end - begin).cwiseProduct(weight.segment(begin, end - begin));
    const Eigen::VectorXd score = J.middleRows(begin, end - begin).transpose() * weighted;
    scores += score * score.transpose();
  }
  const Eigen::VectorXd usual = sigma * sigma * inverse.diagonal();
  const Eigen::VectorXd scattered = (inverse * scores * inverse).diagonal();
  return usual.cwiseMax(scattered).cwiseMax(0.0).cwiseSqrt();
}

double widest_gap(const Eigen::MatrixXd& points, const Eigen::VectorXd& center) {
  std::vector<double> angles;
  angles.reserve(static_cast<std::size_t>(points.rows()) + 1);
  for (Eigen::Index row = 0; row < points.rows(); ++row)
    angles.push_back(std::atan2(points(row, 1) - center(1), points(row, 0) - center(0)));
  std::ranges::sort(angles);
  angles.push_back(angles.front() + 2.0 * std::numbers::pi);
  double gap = 0.0;
  for (std::size_t i = 1; i < angles.size(); ++i) gap = std::max(gap, angles[i] - angles[i - 1]);
  return gap;
}

}  // namespace

std::optional<Iron> fit_iron(const std::vector<Eigen::Vector3d>& fields) {
  if (fields.size() < kFewestFields) return std::nullopt;
  Eigen::MatrixXd all(static_cast<Eigen::Index>(fields.size()), 3);
  for (std::size_t i = 0; i < fields.size(); ++i) all.row(static_cast<Eigen::Index>(i)) = fields[i].transpose();
  const Eigen::RowVector3d middle = all.colwise().mean();
  all.rowwise() -= middle;
  const Eigen::Matrix3d scatter = all.transpose() * all / static_cast<double>(all.rows());
  const Eigen::Vector3d spreads = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvalues().cwiseMax(0.0);
  const double unit = std::sqrt(spreads(2));
  if (!(unit > 0.0) || !std::isfinite(unit)) return std::nullopt;
  const int d = std::sqrt(spreads(0)) > kSpatial * unit ? 3 : 2;
  const Eigen::MatrixXd points = all.leftCols(d) / unit;

  std::optional<Ellipsoid> found = algebraic_ellipsoid(points);
  if (!found) return std::nullopt;
  const Symmetric symmetric{d};
  Eigen::VectorXd residual;
  Eigen::MatrixXd J;
  Eigen::VectorXd weight;
  double sigma = 0.0;
  for (int iteration = 0; iteration < 20; ++iteration) {
    linearize_ellipsoid(points, *found, residual, J);
    weight = ellipsoid_weights(residual, sigma);
    const Eigen::MatrixXd weighted = weight.asDiagonal() * J;
    const Eigen::VectorXd step = -(J.transpose() * weighted).ldlt().solve(weighted.transpose() * residual);
    if (!step.allFinite()) return std::nullopt;
    found->center += step.head(d);
    symmetric.visit([&](int i, int j, int k) {
      found->W(i, j) += step(k);
      if (i != j) found->W(j, i) += step(k);
    });
    if (step.cwiseAbs().maxCoeff() < 1e-9) break;
  }
  const double determinant = found->W.determinant();
  if (!(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(found->W).eigenvalues()(0) > 0.0)) return std::nullopt;
  linearize_ellipsoid(points, *found, residual, J);
  const Eigen::VectorXd of_parameters = ellipsoid_sigmas(J, residual, ellipsoid_weights(residual, sigma), sigma);

  const double radius = std::pow(determinant, -1.0 / d);
  Iron iron;
  iron.axes = d;
  iron.hard.head(d) = middle.head(d).transpose() + unit * found->center;
  iron.hard_sigma.head(d) = unit * of_parameters.head(d);
  iron.soft.topLeftCorner(d, d) = radius * found->W;
  iron.soft_sigma = radius * of_parameters.tail(symmetric.size()).maxCoeff();
  iron.strength = unit * radius;
  iron.scatter = std::sqrt(residual.squaredNorm() / static_cast<double>(residual.size())) / radius;
  if (d == 2) iron.gap_rad = widest_gap(points, found->center);
  return iron;
}

}  // namespace waymark::calibration
