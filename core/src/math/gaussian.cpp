// SPDX-License-Identifier: Apache-2.0
#include "waymark/math/gaussian.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <limits>
#include <numbers>

namespace waymark::gaussian {

Density density(const Vector& nu, const Matrix& S) {
  Matrix L;
  return density(nu, S, L);
}

Density density(const Vector& nu, const Matrix& S, Matrix& L) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  const Eigen::LLT<Matrix> cholesky(S);
  L = cholesky.matrixLLT();  // only its lower half is read
  if (!nu.allFinite() || !S.allFinite() || cholesky.info() != Eigen::Success) return {kNaN, kNaN};
  double squared = 0.0;
  double half_log_determinant = 0.0;
  Vector white = nu;
  for (Eigen::Index i = 0; i < S.rows(); ++i) {
    for (Eigen::Index k = 0; k < i; ++k) white(i) -= L(i, k) * white(k);
    white(i) /= L(i, i);
    squared += white(i) * white(i);
    half_log_determinant += std::log(L(i, i));
  }
  const double log_two_pi = std::log(2.0 * std::numbers::pi);
  return {squared, -0.5 * squared - half_log_determinant - 0.5 * static_cast<double>(nu.size()) * log_two_pi};
}

double chi_squared_quantile(double probability, int dof) {
  return boost::math::quantile(boost::math::chi_squared(dof), probability);
}

Eigen3 eigen(const Eigen::Matrix3d& P) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(P);
  const double threshold = 1e-12 * solver.eigenvalues().maxCoeff();
  const auto keep = [&](double value) { return value > 0.0 && value >= threshold ? value : 0.0; };
  return {solver.eigenvalues().unaryExpr(keep), solver.eigenvectors()};
}

Eigen::Matrix3d square_root(const Eigen::Matrix3d& P) {
  const auto [values, vectors] = eigen(P);
  return vectors * values.cwiseSqrt().asDiagonal() * vectors.transpose();
}

Eigen::MatrixXd divide(const Eigen::MatrixXd& A, const Eigen::MatrixXd& P) {
  // A little noise instead of a rank decision: a direction whose variance is a rounding error gets no gain.
  constexpr double kRounding = 1e-12;
  const Eigen::VectorXd scale =
      P.diagonal().unaryExpr([](double variance) { return variance > 0.0 ? 1.0 / std::sqrt(variance) : 0.0; });
  Eigen::MatrixXd correlation = scale.asDiagonal() * P * scale.asDiagonal();
  correlation.diagonal().array() += kRounding;
  const Eigen::MatrixXd scaled = A * scale.asDiagonal();
  return Eigen::LLT<Eigen::MatrixXd>(correlation).solve(scaled.transpose()).transpose() * scale.asDiagonal();
}

Eigen::Matrix3d excess(const Eigen::Matrix3d& other, const Eigen::Matrix3d& P) {
  constexpr double kLeast = 1e-12;  // a variance below has no scale
  const Eigen::Vector3d scale = P.diagonal().cwiseMax(other.diagonal()).cwiseMax(kLeast).cwiseSqrt();
  const Eigen::Matrix3d difference =
      scale.cwiseInverse().asDiagonal() * (other - P) * scale.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(difference);
  const Eigen::Matrix3d positive =
      eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() * eigen.eigenvectors().transpose();
  return scale.asDiagonal() * positive * scale.asDiagonal();
}

Eigen::Vector3d standard_normal(Random& random) {
  // Named draws: the order of evaluation must not depend on the compiler.
  const double x = random.normal();
  const double y = random.normal();
  const double z = random.normal();
  return {x, y, z};
}

Eigen::Vector3d sample(const Eigen::Matrix3d& P, Random& random) { return square_root(P) * standard_normal(random); }

double log_sum_exp(const double* values, int count) {
  double largest = -std::numeric_limits<double>::infinity();
  for (int i = 0; i < count; ++i) largest = std::max(largest, values[i]);
  if (!std::isfinite(largest)) return largest;
  double sum = 0.0;
  for (int i = 0; i < count; ++i) sum += std::exp(values[i] - largest);
  return largest + std::log(sum);
}

}  // namespace waymark::gaussian
