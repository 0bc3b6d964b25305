// SPDX-License-Identifier: Apache-2.0
#include "waymark/math/gaussian.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <numbers>

namespace waymark::gaussian {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Rank two: nothing is known to vary along (1, 1, 0).
Eigen::Matrix3d singular() {
  Eigen::Matrix<double, 3, 2> B;
  B << 1.0, 0.5, -1.0, -0.5, 0.0, 2.0;
  return B * B.transpose();
}

TEST(Density, MatchesTheFormulaInOneDimension) {
  const Density d = density(Vector::Constant(1, 1.5), Matrix::Constant(1, 1, 4.0));
  EXPECT_DOUBLE_EQ(d.squared_mahalanobis, 1.5 * 1.5 / 4.0);
  EXPECT_NEAR(d.log_density, -0.5 * (1.5 * 1.5 / 4.0) - 0.5 * std::log(2.0 * std::numbers::pi * 4.0), 1e-14);
}

TEST(Density, MatchesInverseAndDeterminant) {
  Eigen::Matrix3d S;
  S << 2.0, 0.3, -0.1, 0.3, 1.0, 0.2, -0.1, 0.2, 0.5;
  const Eigen::Vector3d nu(0.4, -1.0, 0.3);
  const Density d = density(nu, S);
  const double quadratic = nu.dot(S.inverse() * nu);
  EXPECT_NEAR(d.squared_mahalanobis, quadratic, 1e-13);
  EXPECT_NEAR(d.log_density, -0.5 * (quadratic + std::log(std::pow(2.0 * std::numbers::pi, 3) * S.determinant())),
              1e-13);
}

TEST(Density, IsNanForWhatIsNoCovariance) {
  EXPECT_TRUE(std::isnan(density(Vector::Ones(2), Matrix::Zero(2, 2)).log_density));
  EXPECT_TRUE(std::isnan(density(Vector::Ones(2), -Matrix::Identity(2, 2)).squared_mahalanobis));
  EXPECT_TRUE(std::isnan(density(Vector::Constant(1, kInfinity), Matrix::Identity(1, 1)).squared_mahalanobis));
  EXPECT_TRUE(std::isnan(density(Vector::Ones(1), Matrix::Constant(1, 1, std::nan(""))).log_density));
}

TEST(ChiSquaredQuantile, MatchesTheTable) {
  EXPECT_NEAR(chi_squared_quantile(0.95, 1), 3.841459, 1e-6);
  EXPECT_NEAR(chi_squared_quantile(0.99, 2), 9.210340, 1e-6);
  EXPECT_NEAR(chi_squared_quantile(0.999, 3), 16.266236, 1e-6);
}

TEST(SquareRoot, GivesTheCovarianceBackEvenIfSingular) {
  for (const Eigen::Matrix3d& P : {singular(), Eigen::Matrix3d::Zero().eval(), Eigen::Matrix3d::Identity().eval()}) {
    const Eigen::Matrix3d B = square_root(P);
    EXPECT_LT((B * B.transpose() - P).norm(), 1e-13);
    EXPECT_LT((B - B.transpose()).norm(), 1e-13);
  }
}

TEST(SquareRoot, TakesSmallNegativeEigenvaluesAsZero) {
  const Eigen::Matrix3d P = Eigen::Vector3d(1.0, -1e-17, 4.0).asDiagonal();
  const Eigen::Matrix3d B = square_root(P);
  EXPECT_TRUE(B.allFinite());
  EXPECT_NEAR(B(2, 2), 2.0, 1e-15);
}

TEST(EigenOfCovariance, GivesTheMatrixBack) {
  for (const Eigen::Matrix3d& P : {singular(), Eigen::Matrix3d(singular() + 0.1 * Eigen::Matrix3d::Identity())}) {
    const auto [values, vectors] = eigen(P);
    EXPECT_LT((vectors * values.asDiagonal() * vectors.transpose() - P).norm(), 1e-12);
    EXPECT_LT((vectors.transpose() * vectors - Eigen::Matrix3d::Identity()).norm(), 1e-12);
  }
}

TEST(EigenOfCovariance, HasNoValuesFromRounding) {
  EXPECT_EQ((eigen(singular()).values.array() > 0.0).count(), 2);
  EXPECT_EQ(eigen(Eigen::Matrix3d::Zero()).values.norm(), 0.0);
}

TEST(Sample, HasTheCovarianceAndStaysInItsPlane) {
  Random random({.seed = 3, .slot = 1, .stamp = 2, .sensor = 4});
  const Eigen::Matrix3d P = singular();
  constexpr int kCount = 40'000;
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (int i = 0; i < kCount; ++i) {
    const Eigen::Vector3d x = sample(P, random);
    ASSERT_NEAR(x.dot(Eigen::Vector3d(1.0, 1.0, 0.0)), 0.0, 1e-6);
    sum += x * x.transpose();
    mean += x;
  }
  EXPECT_LT((sum / kCount - P).norm(), 0.1);
  EXPECT_LT((mean / kCount).norm(), 0.05);
}

TEST(LogSumExp, DoesNotOverflow) {
  const double values[] = {1000.0, 1000.0 + std::log(3.0), -kInfinity};
  EXPECT_NEAR(log_sum_exp(values, 3), 1000.0 + std::log(4.0), 1e-12);
}

TEST(LogSumExp, OfNothingIsMinusInfinity) {
  const double values[] = {-kInfinity, -kInfinity};
  EXPECT_EQ(log_sum_exp(values, 2), -kInfinity);
  EXPECT_EQ(log_sum_exp(nullptr, 0), -kInfinity);
}

}  // namespace
}  // namespace waymark::gaussian
