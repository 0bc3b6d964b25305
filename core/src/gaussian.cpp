// SPDX-License-Identifier: Apache-2.0
#include "waymark/gaussian.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <limits>
#include <numbers>

namespace waymark::gaussian {

Density density(const Vector& nu, const Matrix& S) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  const Eigen::LLT<Matrix> cholesky(S);
  if (!nu.allFinite() || !S.allFinite() || cholesky.info() != Eigen::Success) return {kNaN, kNaN};
  const Vector white = cholesky.matrixL().solve(nu);
  const double squared = white.squaredNorm();
  double half_log_determinant = 0.0;
  for (Eigen::Index i = 0; i < S.rows(); ++i) half_log_determinant += std::log(cholesky.matrixLLT()(i, i));
  const double log_two_pi = std::log(2.0 * std::numbers::pi);
  return {squared, -0.5 * squared - half_log_determinant - 0.5 * static_cast<double>(nu.size()) * log_two_pi};
}

double chi_squared_quantile(double probability, int dof) {
  return boost::math::quantile(boost::math::chi_squared(dof), probability);
}

Eigen::Matrix3d square_root(const Eigen::Matrix3d& P) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(P);
  const Eigen::Vector3d roots = eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  return eigen.eigenvectors() * roots.asDiagonal() * eigen.eigenvectors().transpose();
}

Eigen::Matrix3d pseudo_inverse(const Eigen::Matrix3d& P) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(P);
  const Eigen::Vector3d& values = eigen.eigenvalues();
  const double threshold = 1e-12 * values.maxCoeff();
  Eigen::Vector3d inverse = Eigen::Vector3d::Zero();
  for (int i = 0; i < 3; ++i) {
    if (values(i) > 0.0 && values(i) >= threshold) inverse(i) = 1.0 / values(i);
  }
  return eigen.eigenvectors() * inverse.asDiagonal() * eigen.eigenvectors().transpose();
}

Eigen::Vector3d sample(const Eigen::Matrix3d& P, Random& random) {
  // Named draws: the order of evaluation must not depend on the compiler.
  const double x = random.normal();
  const double y = random.normal();
  const double z = random.normal();
  return square_root(P) * Eigen::Vector3d(x, y, z);
}

double log_sum_exp(const double* values, int count) {
  double largest = -std::numeric_limits<double>::infinity();
  for (int i = 0; i < count; ++i) largest = std::max(largest, values[i]);
  if (!std::isfinite(largest)) return largest;
  double sum = 0.0;
  for (int i = 0; i < count; ++i) sum += std::exp(values[i] - largest);
  return largest + std::log(sum);
}

}  // namespace waymark::gaussian
