// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <array>

#include "waymark/interface/particle_map.hpp"

namespace waymark {
namespace {

SpatialInformation some_information() {
  SpatialMatrix L = SpatialMatrix::Zero();
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j <= i; ++j) L(i, j) = i == j ? 5.0 + i : 0.7 * (i - j) - 0.3 * j;
  }
  SpatialVector mean;
  mean << 0.1, -0.2, 0.05, 0.01, -0.03, 0.02;
  const SpatialMatrix information = L * L.transpose();
  return {information, information * mean};
}

// The marginal of a Gaussian keeps the covariance and the mean of what it keeps.
TEST(SpatialInformation, MarginalsHaveTheCovarianceAndTheMeanOfTheWhole) {
  const SpatialInformation about = some_information();
  const SpatialMatrix P = about.information.inverse();
  const SpatialVector mean = P * about.gradient;
  const auto expect = [&](const SpatialInformation::Marginal& marginal, const std::array<int, 3>& kept) {
    const Eigen::Matrix3d covariance = P(kept, kept);
    EXPECT_LT((marginal.information.inverse() - covariance).norm(), 1e-6 * covariance.norm());
    EXPECT_LT((covariance * marginal.gradient - mean(kept)).norm(), 1e-6);
  };
  expect(about.planar(), {0, 1, 5});
  expect(about.height_and_tilt(), {2, 3, 4});
}

TEST(SpatialInformation, AFloorAloneDoesNotConstrainThePlane) {
  SpatialInformation about{SpatialMatrix::Zero(), SpatialVector::Zero()};
  about.information.diagonal() << 0.0, 0.0, 100.0, 50.0, 50.0, 0.0;
  EXPECT_TRUE(about.planar().information.isZero(1e-12));
  EXPECT_NEAR(about.height_and_tilt().information(0, 0), 100.0, 1e-12);
}

}  // namespace
}  // namespace waymark
