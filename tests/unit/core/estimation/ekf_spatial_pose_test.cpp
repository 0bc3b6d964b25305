// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>

#include "estimation/ekf.hpp"
#include "unit/core/beliefs.hpp"

namespace waymark {
namespace {

constexpr int kSize = 14;  // 12 and a block of two

class SpatialPoseFilter : public ::testing::Test {
 protected:
  Belief random_belief() {
    Belief belief{{}, test::random_state(layout_, random_), test::random_covariance(layout_.size(), random_)};
    return belief;
  }
  SpatialMatrix random_information(int rank) {
    Eigen::MatrixXd L(6, rank);
    for (int i = 0; i < rank; ++i) L.col(i) = 2.0 * test::normals(6, random_);
    return L * L.transpose();
  }

  const StateLayout layout_{StateLayout::Motion::spatial, {{"gps", test::block_of(2)}}};
  Random random_ = test::stream(22);
};

TEST_F(SpatialPoseFilter, InformationMatchesThePlainFormula) {
  for (int trial = 0; trial < 60; ++trial) {
    Belief belief = random_belief();
    const Belief before = belief;
    const SpatialMatrix information = random_information(1 + trial % 6);  // also singular ones
    const SpatialVector gradient = information * 0.05 * test::normals(6, random_);
    ASSERT_TRUE(estimation::ekf::apply_spatial_information(belief, layout_, information, gradient));
    Eigen::MatrixXd total = Eigen::MatrixXd(before.P).inverse();
    total.topLeftCorner(6, 6) += information;
    const Eigen::MatrixXd P = total.inverse();
    const Eigen::VectorXd delta = P.leftCols(6) * gradient;
    EXPECT_LT((belief.P - P).cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_LT((boxminus(belief.mean, before.mean, layout_) - delta).norm(), 1e-9);
  }
}

TEST_F(SpatialPoseFilter, PlanarInformationIsThatOfThreeOfTheSix) {
  Belief belief = random_belief();
  Belief other = belief;
  const Eigen::Matrix3d information = random_information(6).topLeftCorner<3, 3>();
  const Eigen::Vector3d gradient = information * 0.1 * test::normals(3, random_);
  SpatialMatrix all = SpatialMatrix::Zero();
  SpatialVector of_all = SpatialVector::Zero();
  const std::array<int, 3> planar{0, 1, 5};
  all(planar, planar) = information;
  of_all(planar) = gradient;
  ASSERT_TRUE(estimation::ekf::apply_pose_information(belief, layout_, information, gradient));
  ASSERT_TRUE(estimation::ekf::apply_spatial_information(other, layout_, all, of_all));
  EXPECT_LT((belief.P - other.P).cwiseAbs().maxCoeff(), 1e-10);
  EXPECT_LT(boxminus(belief.mean, other.mean, layout_).norm(), 1e-10);
}

TEST_F(SpatialPoseFilter, InformationThatIsNotFiniteIsRefused) {
  Belief belief = random_belief();
  const Belief before = belief;
  SpatialMatrix information = random_information(6);
  information(4, 4) = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(estimation::ekf::apply_spatial_information(belief, layout_, information, SpatialVector::Zero()));
  EXPECT_EQ(belief.P, before.P);
}

// As in the plane (ekf_pose_test.cpp): five σ per entry, of 105 different ones and 3 fractions, fail by chance with a
// probability below 2e-4.
TEST_F(SpatialPoseFilter, SpreadOfTheMeansPlusTheRestIsTheWholeCovariance) {
  constexpr int kDraws = 20'000;
  Belief prior = random_belief();
  prior.P *= 1e-4;  // the attitude's error states are a tangent space: large turns do not add
  for (const double fraction : {0.0, 0.5, 1.0}) {
    Eigen::MatrixXd spread = Eigen::MatrixXd::Zero(kSize, kSize);
    Belief drawn;
    for (int i = 0; i < kDraws; ++i) {
      drawn = prior;
      estimation::ekf::sample_spatial_pose(drawn, layout_, fraction, random_);
      const Eigen::VectorXd d = boxminus(drawn.mean, prior.mean, layout_);
      spread += d * d.transpose() / kDraws;
    }
    const Eigen::MatrixXd expected = prior.P - drawn.P;
    for (int i = 0; i < kSize; ++i) {
      for (int j = 0; j <= i; ++j) {
        const double variance = expected(i, j) * expected(i, j) + expected(i, i) * expected(j, j);
        EXPECT_LE(std::abs(spread(i, j) - expected(i, j)), 5.0 * std::sqrt(std::max(variance, 0.0) / kDraws) + 1e-12)
            << fraction << ": " << i << ", " << j;
      }
    }
    EXPECT_GT(test::smallest_eigenvalue(drawn.P), -1e-12);
    EXPECT_LE(test::asymmetry(drawn.P), test::asymmetry(prior.P));
  }
}

TEST_F(SpatialPoseFilter, FractionOneMakesAllSixAPointAndConditionsTheRestOnThem) {
  Belief prior = random_belief();
  prior.P *= 0.01;
  Belief drawn = prior;
  estimation::ekf::sample_spatial_pose(drawn, layout_, 1.0, random_);
  EXPECT_LT(drawn.P.topRows(6).cwiseAbs().maxCoeff(), 1e-12);
  const Eigen::MatrixXd gain = prior.P.bottomLeftCorner(kSize - 6, 6) * spatial_covariance(prior).inverse();
  const ErrorVector moved = boxminus(drawn.mean, prior.mean, layout_);
  EXPECT_GT(moved.head(6).norm(), 1e-3);
  EXPECT_LT((moved.tail(kSize - 6) - gain * moved.head(6)).norm(), 1e-9);
}

}  // namespace
}  // namespace waymark
