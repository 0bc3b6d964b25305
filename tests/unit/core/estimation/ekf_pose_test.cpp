// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>

#include "estimation/ekf.hpp"
#include "unit/core/beliefs.hpp"

namespace waymark {
namespace {

class PoseFilter : public ::testing::Test {
 protected:
  Belief random_belief() {
    Belief belief{{}, test::random_state(layout_, random_), test::random_covariance(layout_.size(), random_)};
    return belief;
  }
  /// All but the heading is certain.
  Belief heading(double variance) {
    Belief belief = random_belief();
    belief.mean.T_map_base = {};
    belief.P.setZero();
    belief.P(2, 2) = variance;
    return belief;
  }
  void forget_pose_uncertainty(Belief& belief, int from = 0) const {
    for (int i = from; i < 3; ++i) {
      belief.P.row(i).setZero();
      belief.P.col(i).setZero();
    }
  }
  Eigen::Matrix3d random_information(int rank) {
    Eigen::MatrixXd L(3, rank);
    for (int i = 0; i < rank; ++i) L.col(i) = 2.0 * test::normals(3, random_);
    return L * L.transpose();
  }

  const StateLayout layout_{StateLayout::Motion::planar, {{"gps", test::block_of(2)}}};
  Random random_ = test::stream(21);
};

TEST_F(PoseFilter, InformationMatchesThePlainFormulaWhereItExists) {
  for (int trial = 0; trial < 60; ++trial) {
    Belief belief = random_belief();
    const Belief before = belief;
    const Eigen::Matrix3d information = random_information(1 + trial % 3);  // also singular ones
    const Eigen::Vector3d gradient = information * 0.1 * test::normals(3, random_);
    ASSERT_TRUE(estimation::ekf::apply_pose_information(belief, layout_, information, gradient));
    Eigen::MatrixXd total = Eigen::MatrixXd(before.P).inverse();
    total.topLeftCorner(3, 3) += information;
    const Eigen::MatrixXd P = total.inverse();
    const Eigen::VectorXd delta = P.leftCols(3) * gradient;
    EXPECT_LT((belief.P - P).cwiseAbs().maxCoeff(), 1e-10);
    EXPECT_LT((boxminus(belief.mean, before.mean, layout_) - delta).norm(), 1e-10);
  }
}

TEST_F(PoseFilter, InformationAboutAPoseThatIsCertainChangesNothing) {
  Belief belief = random_belief();
  forget_pose_uncertainty(belief);
  const Belief before = belief;
  ASSERT_TRUE(
      estimation::ekf::apply_pose_information(belief, layout_, random_information(3), test::normals(3, random_)));
  EXPECT_EQ(belief.P, before.P);
  EXPECT_EQ(boxminus(belief.mean, before.mean, layout_).norm(), 0.0);
}

TEST_F(PoseFilter, InformationWithACertainHeadingMatchesTheFormulaOfTheRest) {
  Belief belief = random_belief();
  forget_pose_uncertainty(belief, 2);
  const Belief before = belief;
  const Eigen::Matrix3d information = random_information(3);
  const Eigen::Vector3d gradient = information * 0.1 * test::normals(3, random_);
  ASSERT_TRUE(estimation::ekf::apply_pose_information(belief, layout_, information, gradient));
  const Eigen::Matrix3d Pyy = pose_covariance(before, layout_);
  const Eigen::MatrixXd inner = (Eigen::Matrix3d::Identity() + information * Pyy).inverse();
  const Eigen::MatrixXd P =
      Eigen::MatrixXd(before.P) - before.P.leftCols(3) * inner * information * before.P.topRows(3);
  EXPECT_LT((belief.P - P).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT((boxminus(belief.mean, before.mean, layout_) - before.P.leftCols(3) * inner * gradient).norm(), 1e-12);
  EXPECT_TRUE(belief.P.row(2).isZero(0.0));
}

// While the robot stands, nothing gives a pose that was sampled as a whole its variance back: what is left is rounding,
// and must not be divided by.
TEST_F(PoseFilter, SamplingAWholePoseAgainAndAgainMovesNothingElse) {
  Belief belief = random_belief();
  estimation::ekf::sample_pose(belief, layout_, 1.0, random_);
  const Belief before = belief;
  for (int scan = 0; scan < 2000; ++scan) estimation::ekf::sample_pose(belief, layout_, 1.0, random_);
  EXPECT_LT(boxminus(belief.mean, before.mean, layout_).norm(), 1e-6);
  EXPECT_LT((belief.P - before.P).cwiseAbs().maxCoeff(), 1e-9);
}

TEST_F(PoseFilter, ACorridorStaysUncertainAlongItsAxis) {
  Belief belief;
  belief.mean.block = BlockVector::Zero(2);
  belief.P = ErrorMatrix::Identity(8, 8);
  const Eigen::Matrix3d information = Eigen::Vector3d(0.0, 1e4, 1e4).asDiagonal();
  ASSERT_TRUE(estimation::ekf::apply_pose_information(belief, layout_, information, Eigen::Vector3d(0.0, 1e4, 0.0)));
  EXPECT_DOUBLE_EQ(belief.P(0, 0), 1.0);
  EXPECT_NEAR(belief.P(1, 1), 1.0 / (1.0 + 1e4), 1e-12);
  EXPECT_NEAR(belief.mean.T_map_base.p.y(), 1e4 / (1.0 + 1e4), 1e-9);
  EXPECT_EQ(belief.mean.T_map_base.p.x(), 0.0);
}

TEST_F(PoseFilter, NoInformationChangesNothing) {
  Belief belief = random_belief();
  const Belief before = belief;
  ASSERT_TRUE(
      estimation::ekf::apply_pose_information(belief, layout_, Eigen::Matrix3d::Zero(), Eigen::Vector3d::Zero()));
  EXPECT_EQ(belief.P, before.P);
}

TEST_F(PoseFilter, InformationThatIsNotFiniteIsRefused) {
  Belief belief = random_belief();
  const Belief before = belief;
  Eigen::Matrix3d information = random_information(3);
  EXPECT_FALSE(
      estimation::ekf::apply_pose_information(belief, layout_, information, Eigen::Vector3d(0.0, std::nan(""), 0.0)));
  information(1, 1) = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(estimation::ekf::apply_pose_information(belief, layout_, information, Eigen::Vector3d::Zero()));
  EXPECT_EQ(belief.P, before.P);
  EXPECT_EQ(belief.mean.T_map_base.p, before.mean.T_map_base.p);
}

// The sample covariance of N Gaussian draws has entries with variance (C_ij² + C_ii C_jj) / N. Five σ per entry, of 36
// different ones and 5 fractions, fail by chance with a probability below 2e-4.
TEST_F(PoseFilter, SpreadOfTheMeansPlusTheRestIsTheWholeCovariance) {
  constexpr int kDraws = 20'000;
  Belief prior = random_belief();
  prior.P *= 0.04;  // no draw may turn the heading by more than half a turn
  for (const double fraction : {0.0, 0.2, 0.5, 0.9, 1.0}) {
    Eigen::MatrixXd spread = Eigen::MatrixXd::Zero(8, 8);
    Eigen::VectorXd mean = Eigen::VectorXd::Zero(8);
    Belief drawn;
    for (int i = 0; i < kDraws; ++i) {
      drawn = prior;
      estimation::ekf::sample_pose(drawn, layout_, fraction, random_);
      const Eigen::VectorXd d = boxminus(drawn.mean, prior.mean, layout_);
      spread += d * d.transpose() / kDraws;
      mean += d / kDraws;
    }
    const Eigen::MatrixXd expected = prior.P - drawn.P;
    for (int i = 0; i < 8; ++i) {
      EXPECT_LE(std::abs(mean[i]), 5.0 * std::sqrt(std::max(expected(i, i), 0.0) / kDraws) + 1e-12) << fraction;
      for (int j = 0; j <= i; ++j) {
        const double variance = expected(i, j) * expected(i, j) + expected(i, i) * expected(j, j);
        EXPECT_LE(std::abs(spread(i, j) - expected(i, j)), 5.0 * std::sqrt(std::max(variance, 0.0) / kDraws) + 1e-12)
            << fraction << ": " << i << ", " << j;
      }
    }
    EXPECT_GT(test::smallest_eigenvalue(drawn.P), -1e-12);
    EXPECT_EQ(test::asymmetry(drawn.P), 0.0);
  }
}

TEST_F(PoseFilter, FractionZeroKeepsTheBelief) {
  const Belief prior = random_belief();
  Belief drawn = prior;
  estimation::ekf::sample_pose(drawn, layout_, 0.0, random_);
  EXPECT_EQ(drawn.P, prior.P);
  EXPECT_EQ(boxminus(drawn.mean, prior.mean, layout_).norm(), 0.0);
}

TEST_F(PoseFilter, FractionOneMakesThePoseAPointAndConditionsTheRestOnIt) {
  const Belief prior = random_belief();
  Belief drawn = prior;
  estimation::ekf::sample_pose(drawn, layout_, 1.0, random_);
  EXPECT_LT(drawn.P.topRows(3).cwiseAbs().maxCoeff(), 1e-12);
  const Eigen::MatrixXd gain = prior.P.bottomLeftCorner(5, 3) * pose_covariance(prior, layout_).inverse();
  const Eigen::MatrixXd rest = Eigen::MatrixXd(prior.P.bottomRightCorner(5, 5)) - gain * prior.P.topRightCorner(3, 5);
  EXPECT_LT((drawn.P.bottomRightCorner(5, 5) - rest).cwiseAbs().maxCoeff(), 1e-11);
  const ErrorVector moved = boxminus(drawn.mean, prior.mean, layout_);
  EXPECT_GT(moved.head(3).norm(), 1e-3);
  EXPECT_LT((moved.tail(5) - gain * moved.head(3)).norm(), 1e-11);
}

TEST_F(PoseFilter, SamplingACertainPoseDrawsNothing) {
  Belief belief = random_belief();
  forget_pose_uncertainty(belief);
  const Belief before = belief;
  estimation::ekf::sample_pose(belief, layout_, 1.0, random_);
  EXPECT_EQ(belief.P, before.P);
  EXPECT_EQ(boxminus(belief.mean, before.mean, layout_).norm(), 0.0);
}

TEST_F(PoseFilter, SamplingWithACertainHeadingLeavesItAlone) {
  Belief belief = random_belief();
  forget_pose_uncertainty(belief, 2);
  const Belief before = belief;
  estimation::ekf::sample_pose(belief, layout_, 1.0, random_);
  const ErrorVector moved = boxminus(belief.mean, before.mean, layout_);
  EXPECT_GT(moved.head(2).norm(), 1e-3);
  EXPECT_NEAR(moved[2], 0.0, 1e-12);
  EXPECT_LT(belief.P.topRows(3).cwiseAbs().maxCoeff(), 1e-12);
}

/// Mapping steps: the motion adds variance `noise` to the heading, a match gives `information` about it, and a share
/// `fraction` of what is left is drawn.
struct MappingSteps {
  double noise;        // [rad²]
  double information;  // [1/rad²]
  double fraction;
  double drawn = 0.0;  // sum of the variances [rad²]

  void run(int steps, Belief& belief, const StateLayout& layout, Random& random) {
    const Eigen::Matrix3d of_heading = Eigen::Vector3d(0.0, 0.0, information).asDiagonal();
    for (int step = 0; step < steps; ++step) {
      belief.P(2, 2) += noise;
      ASSERT_TRUE(estimation::ekf::apply_pose_information(belief, layout, of_heading, Eigen::Vector3d::Zero()));
      const double before = belief.P(2, 2);
      estimation::ekf::sample_pose(belief, layout, fraction, random);
      drawn += before - belief.P(2, 2);
    }
  }
};

// So a robot with exact odometry does not lose its heading by being mapped often (docs/math/rbpf.md).
TEST_F(PoseFilter, MappingStepsDrawNoMoreThanTheMotionAdded) {
  constexpr double kStart = 1e-4;  // [rad²]
  constexpr int kSteps = 1000;
  for (const double fraction : {0.01, 0.2, 1.0}) {
    for (const double noise : {0.0, 1e-6}) {
      for (const double information : {0.0, 1e5}) {
        Belief belief = heading(kStart);
        MappingSteps steps{noise, information, fraction};
        steps.run(kSteps, belief, layout_, random_);
        const double added = kStart + kSteps * noise;
        EXPECT_LE(steps.drawn, added * (1.0 + 1e-9)) << fraction << " " << noise << " " << information;
        if (information == 0.0) {
          EXPECT_NEAR(steps.drawn + belief.P(2, 2), added, 1e-9 * added);
        }
      }
    }
  }
}

TEST_F(PoseFilter, HeadingsDrawnInManyStepsSpreadAsTheSumOfTheirVariances) {
  constexpr int kRuns = 2000;
  double square = 0.0;
  double expected = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    Belief belief = heading(0.0);
    MappingSteps steps{1e-5, 1e4, 0.2};
    steps.run(100, belief, layout_, random_);
    square += std::pow(belief.mean.T_map_base.yaw(), 2) / kRuns;
    expected = steps.drawn;
  }
  EXPECT_NEAR(square, expected, 5.0 * std::sqrt(2.0 / kRuns) * expected);
}

// After many steps Λ(1 − a)P² + (a + Λq)P = q, and a·P of q is drawn.
TEST_F(PoseFilter, AShareOfTheMotionsNoiseIsDrawnInTheLongRun) {
  constexpr double kNoise = 1e-5;
  constexpr double kInformation = 1e4;
  for (const double fraction : {0.01, 0.2, 0.9}) {
    Belief belief = heading(0.0);
    MappingSteps steps{kNoise, kInformation, fraction};
    steps.run(2000, belief, layout_, random_);
    steps.drawn = 0.0;
    steps.run(1, belief, layout_, random_);
    const double A = kInformation * (1.0 - fraction);
    const double b = fraction + kInformation * kNoise;
    const double P = (std::sqrt(b * b + 4.0 * A * kNoise) - b) / (2.0 * A);
    EXPECT_NEAR(steps.drawn, fraction * P, 1e-9 * kNoise) << fraction;
  }
}

}  // namespace
}  // namespace waymark
