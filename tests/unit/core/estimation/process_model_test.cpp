// SPDX-License-Identifier: Apache-2.0
#include "estimation/process_model.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "unit/core/beliefs.hpp"

namespace waymark {
namespace {

using Motion = StateLayout::Motion;

StateBlock mixed_block() {
  StateBlock block = test::block_of(3);
  block[0].tau_s = 5.0;
  block[0].stationary_sigma = 0.3;
  block[1].walk_per_sqrt_s = 0.02;
  block[2].walk_per_sqrt_m = 0.01;
  return block;
}

const ProcessNoise kNoise{{0.5, 0.2, 0.1}, {0.1, 0.2, 0.3}};

class Process : public ::testing::TestWithParam<Motion> {
 protected:
  /// d f(x ⊞ δ) / dδ by central differences.
  ErrorMatrix numerical_transition(const NavState& mean, double dt) const {
    constexpr double kStep = 1e-4;
    ErrorMatrix F(layout_.size(), layout_.size());
    for (int i = 0; i < layout_.size(); ++i) {
      NavState plus = mean;
      NavState minus = mean;
      boxplus(plus, kStep * ErrorVector::Unit(layout_.size(), i), layout_);
      boxplus(minus, -kStep * ErrorVector::Unit(layout_.size(), i), layout_);
      model_.predict_mean(plus, dt);
      model_.predict_mean(minus, dt);
      F.col(i) = boxminus(plus, minus, layout_) / (2.0 * kStep);
    }
    return F;
  }

  Belief random_belief(double rate = 1.0) {
    return {at(10.0), test::random_state(layout_, random_, rate), test::random_covariance(layout_.size(), random_)};
  }
  static Time at(double seconds) { return test::at(seconds); }

  const StateLayout layout_{GetParam(), {{"sensor", mixed_block()}}};
  const estimation::ProcessModel model_{layout_, kNoise};
  Random random_ = test::stream(3);
};

TEST_P(Process, TransitionMatchesCentralDifferences) {
  for (int i = 0; i < 100; ++i) {
    const NavState mean = test::random_state(layout_, random_);
    const double dt = test::uniform(random_, 0.001, 1.0);
    EXPECT_LT((model_.transition(mean, dt) - numerical_transition(mean, dt)).cwiseAbs().maxCoeff(), 1e-6);
  }
}

TEST_P(Process, TransitionMatchesCentralDifferencesAtTinyTurnRates) {
  // 1e-3 rad is where the planar arc changes from the series to the closed form.
  for (const double rate : {0.0, 1e-12, 1e-9, 1e-6, 1e-4, 0.9e-3, 1.1e-3, 1e-2}) {
    NavState mean = test::random_state(layout_, random_, rate);
    mean.w_base.z() = rate;
    EXPECT_LT((model_.transition(mean, 1.0) - numerical_transition(mean, 1.0)).cwiseAbs().maxCoeff(), 1e-6) << rate;
  }
}

TEST_P(Process, WithoutNoiseTheCovarianceIsCarriedByTheTransition) {
  Belief belief = random_belief();
  const Belief before = belief;
  model_.predict(belief, at(10.3), true);
  const ErrorMatrix F = model_.transition(before.mean, 0.3);
  const int core = layout_.core_size();
  const ErrorMatrix expected = F * before.P * F.transpose();
  EXPECT_LT((belief.P - expected).topLeftCorner(core, layout_.size()).cwiseAbs().maxCoeff(), 1e-12);
}

TEST_P(Process, StandingAddsNothingToPoseAndTwist) {
  Belief belief = random_belief();
  belief.mean.v_base.setZero();
  belief.mean.w_base.setZero();
  for (int i = 0; i < kCoreStates; ++i) {
    const int k = layout_.active(i);
    if (i < 6 || k < 0) continue;
    belief.P.row(k).setZero();
    belief.P.col(k).setZero();
  }
  const Belief before = belief;
  for (int k = 1; k <= 600; ++k) model_.predict(belief, at(10.0 + k), true);
  const int core = layout_.core_size();
  EXPECT_EQ(belief.P.topLeftCorner(core, core), before.P.topLeftCorner(core, core));
  EXPECT_EQ(belief.mean.T_map_base.p, before.mean.T_map_base.p);
}

// Compared are the covariances after dt in one prediction and in two halves. Their difference may be of second order
// only: halving dt must divide it by about four or more, and it must be small against what dt added.
TEST_P(Process, SplittingAnIntervalGivesTheSameCovarianceToFirstOrder) {
  const auto difference = [&](const Belief& start, double dt) {
    Belief once = start;
    Belief twice = start;
    model_.predict(once, start.stamp + from_seconds(dt), false);
    model_.predict(twice, start.stamp + from_seconds(0.5 * dt), false);
    model_.predict(twice, start.stamp + from_seconds(dt), false);
    return (once.P - twice.P).norm();
  };
  for (int i = 0; i < 50; ++i) {
    Belief start = random_belief();
    const double coarse = difference(start, 0.08);
    EXPECT_LT(difference(start, 0.04), 0.3 * coarse + 1e-12);
    Belief end = start;
    model_.predict(end, start.stamp + from_seconds(0.08), false);
    EXPECT_LT(coarse, 0.01 * (end.P - start.P).norm());
  }
}

TEST_P(Process, SplittingIsExactForStraightMotion) {
  Belief once = random_belief();
  once.mean.w_base.setZero();
  if (GetParam() == Motion::spatial) once.mean.v_base.setZero();  // a moving body's attitude couples into its position
  Belief many = once;
  model_.predict(once, at(12.0), false);
  for (int k = 1; k <= 20; ++k) model_.predict(many, at(10.0 + 0.1 * k), false);
  EXPECT_LT((once.P - many.P).cwiseAbs().maxCoeff(), 1e-9);
}

TEST_P(Process, CovarianceStaysSymmetricAndPositive) {
  Belief belief = random_belief(0.2);
  for (int k = 1; k <= 2000; ++k) {
    model_.predict(belief, at(10.0 + 0.05 * k), k % 3 == 0);
    ASSERT_LT(test::asymmetry(belief.P), 1e-10 * belief.P.norm()) << k;
  }
  EXPECT_GT(test::smallest_eigenvalue(belief.P), -1e-12 * belief.P.norm());
}

INSTANTIATE_TEST_SUITE_P(Motions, Process, ::testing::Values(Motion::planar, Motion::spatial),
                         [](const auto& motion) { return motion.param == Motion::planar ? "Planar" : "Spatial"; });

TEST(PredictMean, DrivesAQuarterCircle) {
  const StateLayout layout(Motion::planar, {});
  const estimation::ProcessModel model(layout, kNoise);
  NavState state;
  state.v_base.x() = 2.0;
  state.w_base.z() = 0.5;  // a circle of radius 4 m
  model.predict_mean(state, std::acos(0.0) / 0.5);
  EXPECT_LT((state.T_map_base.p - Eigen::Vector3d(4.0, 4.0, 0.0)).norm(), 1e-12);
  EXPECT_NEAR(state.T_map_base.yaw(), std::acos(0.0), 1e-12);
}

TEST(PredictMean, PlanarAndSpatialAgreeInThePlane) {
  const StateLayout planar(Motion::planar, {});
  const StateLayout spatial(Motion::spatial, {});
  Random random = test::stream(4);
  for (int i = 0; i < 100; ++i) {
    NavState a = test::random_state(planar, random);
    NavState b = a;
    estimation::ProcessModel(planar, kNoise).predict_mean(a, 0.7);
    estimation::ProcessModel(spatial, kNoise).predict_mean(b, 0.7);
    EXPECT_LT(boxminus(a, b, spatial).norm(), 1e-10);
  }
}

class Blocks : public ::testing::Test {
 protected:
  Belief standing_belief() const {
    Belief belief;
    belief.mean.block = BlockVector::Ones(3);
    belief.P = ErrorMatrix::Identity(9, 9);
    return belief;
  }
  const StateLayout layout_{Motion::planar, {{"sensor", mixed_block()}}};
  const estimation::ProcessModel model_{layout_, kNoise};
};

TEST_F(Blocks, GaussMarkovDecaysInMeanCorrelationAndTowardsItsStationarySigma) {
  Belief belief = standing_belief();
  belief.P(0, 6) = belief.P(6, 0) = 0.5;
  model_.predict(belief, test::at(5.0), true);
  const double decay = std::exp(-1.0);
  EXPECT_NEAR(belief.mean.block[0], decay, 1e-12);
  EXPECT_NEAR(belief.P(0, 6), 0.5 * decay, 1e-12);
  EXPECT_NEAR(belief.P(6, 0), 0.5 * decay, 1e-12);
  EXPECT_NEAR(belief.P(6, 6), decay * decay + 0.09 * (1.0 - decay * decay), 1e-12);
  for (int k = 1; k <= 100; ++k) model_.predict(belief, test::at(5.0 + k), true);
  EXPECT_NEAR(belief.P(6, 6), 0.09, 1e-12);
}

TEST_F(Blocks, CorrelatedGaussMarkovStatesDecayTogether) {
  StateBlock block = test::block_of(2);
  block[0].tau_s = 5.0;
  block[1].tau_s = 2.0;
  const StateLayout layout(Motion::planar, {{"gps", block}});
  const estimation::ProcessModel model(layout, kNoise);
  Belief belief;
  belief.mean.block = BlockVector::Zero(2);
  belief.P = ErrorMatrix::Identity(8, 8);
  belief.P(6, 7) = belief.P(7, 6) = 0.8;
  model.predict(belief, test::at(1.0), true);
  EXPECT_NEAR(belief.P(6, 7), 0.8 * std::exp(-1.0 / 5.0 - 1.0 / 2.0), 1e-12);
  EXPECT_NEAR(belief.P(7, 6), belief.P(6, 7), 1e-15);
}

TEST_F(Blocks, RandomWalkInTimeGrowsWithTheRootOfTime) {
  Belief belief = standing_belief();
  model_.predict(belief, test::at(100.0), true);
  EXPECT_NEAR(belief.P(7, 7), 1.0 + 0.02 * 0.02 * 100.0, 1e-12);
  EXPECT_EQ(belief.mean.block[1], 1.0);
}

TEST_F(Blocks, RandomWalkInDistanceGrowsWithTheDistanceDrivenAndNotAtStandstill) {
  Belief belief = standing_belief();
  belief.mean.v_base.x() = 2.0;
  model_.predict(belief, test::at(10.0), false);
  EXPECT_NEAR(belief.P(8, 8), 1.0 + 0.01 * 0.01 * 20.0, 1e-12);
  model_.predict(belief, test::at(20.0), true);
  EXPECT_NEAR(belief.P(8, 8), 1.0 + 0.01 * 0.01 * 20.0, 1e-12);
}

}  // namespace
}  // namespace waymark
