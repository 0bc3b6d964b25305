// SPDX-License-Identifier: Apache-2.0
#include "particles/particle_filter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "unit/core/particle_run.hpp"

namespace waymark {
namespace {

using test::ParticleRun;
using test::PositionModel;
using test::TwistModel;

ParticleFilterSettings spread_settings(int particles) {
  ParticleFilterSettings settings;
  settings.particles = particles;
  settings.sampling_fraction = 0.7;
  return settings;
}

particles::UpdatePolicy policy(double probability = 0.999) {
  particles::UpdatePolicy p;
  p.gates = particles::Gates(probability);
  return p;
}

TEST(ParticleFilter, WithOneParticleIsAPlainEkf) {
  ParticleRun run({});
  particles::ParticleFilter& filter = run.filter();
  filter.start(run.prior(), false);
  Belief expected = run.prior();
  const PositionModel model({0.4, -0.2}, 0.3);
  filter.predict(test::at(1.0), false);
  const particles::MixtureOutcome outcome = filter.update(model, policy());

  run.process().predict(expected, test::at(1.0), false);
  Linearization linear;
  estimation::ekf::Innovation innovation;
  model.linearize({expected.mean, nullptr}, linear);
  test::innovate(expected, run.layout(), 0, linear, innovation);
  estimation::ekf::apply(expected, run.layout(), innovation);
  EXPECT_EQ(filter.mixture().P, expected.P);
  EXPECT_EQ(filter.mixture().mean.T_map_base.p, expected.mean.T_map_base.p);
  EXPECT_TRUE(outcome.accepted);
  EXPECT_DOUBLE_EQ(outcome.nis, innovation.density.squared_mahalanobis);
}

TEST(ParticleFilter, PathsDoNotGrowBeyondTheirBound) {
  ParticleFilterSettings settings = spread_settings(3);
  settings.path_poses = 100;
  ParticleRun run(settings);
  particles::ParticleFilter& filter = run.filter();
  filter.start(run.prior(), true);
  for (int i = 1; i <= 2000; ++i) {
    filter.predict(test::at(i), false);
    if (i % 3 == 0) filter.record_tentative_path();
    if (i % 3 != 0) filter.record_path();
    for (const particles::Particle& particle : filter.particles()) ASSERT_LE(particle.path.size(), 100U) << i;
  }
  const std::vector<StampedPose> poses = filter.particles()[0].path.poses();
  EXPECT_GT(poses.size(), 60U);
  EXPECT_EQ(poses.front().stamp, test::at(1)) << "the beginning is not cut off";
  EXPECT_EQ(poses.back().stamp, test::at(2000));
}

TEST(ParticleFilter, MixtureHasTheMomentsWithinPlusBetween) {
  ParticleRun run(spread_settings(40));
  particles::ParticleFilter& filter = run.filter();
  filter.start(run.prior(), true);
  filter.update(PositionModel({0.5, 0.5}, 0.8), policy());

  ErrorVector mean = ErrorVector::Zero(6);
  const NavState origin = run.prior().mean;
  for (const particles::Particle& p : filter.particles())
    mean += std::exp(p.log_weight) * boxminus(p.belief.mean, origin, run.layout());
  ErrorMatrix P = ErrorMatrix::Zero(6, 6);
  for (const particles::Particle& p : filter.particles()) {
    const ErrorVector d = boxminus(p.belief.mean, origin, run.layout()) - mean;
    P += std::exp(p.log_weight) * (p.belief.P + d * d.transpose());
  }
  EXPECT_LT((boxminus(filter.mixture().mean, origin, run.layout()) - mean).norm(), 1e-12);
  EXPECT_LT((filter.mixture().P - P).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(ParticleFilter, MeanHeadingIsCircular) {
  ParticleRun run(spread_settings(200));
  Belief prior = run.prior();
  prior.mean.T_map_base = Pose::planar(0.0, 0.0, std::numbers::pi);
  run.filter().start(prior, true);
  // 200 draws of σ = 0.3·√0.7: the mean's σ is 0.018; six of them.
  EXPECT_LT(std::abs(so3::wrap(run.filter().mixture().mean.T_map_base.yaw() - std::numbers::pi)), 0.11);
  EXPECT_LT(run.filter().mixture().P(2, 2), 0.2);
}

TEST(ParticleFilter, AnUpdateWeighsByItsEvidence) {
  ParticleRun run(spread_settings(10));
  particles::ParticleFilter& filter = run.filter();
  filter.start(run.prior(), true);
  const PositionModel model({0.5, 0.5}, 0.8);
  std::vector<double> expected = test::log_evidences(run, model);
  particles::UpdatePolicy tempered = policy();
  tempered.weight_exponent = 0.3;
  filter.update(model, tempered);
  for (double& w : expected) w *= 0.3;
  const double sum = gaussian::log_sum_exp(expected.data(), 10);
  for (std::size_t i = 0; i < 10; ++i) EXPECT_NEAR(filter.particles()[i].log_weight, expected[i] - sum, 1e-12);
}

TEST(ParticleFilter, AGatedUpdateMovesNobodyAndCountsItsLikelihoodClampedAtTheGate) {
  ParticleRun run(spread_settings(200));
  particles::ParticleFilter& filter = run.filter();
  filter.start(run.prior(), true);
  const std::vector<particles::Particle>& particles = filter.particles();
  const Belief first = particles[0].belief;
  const PositionModel model({1.8, 1.8}, 0.3);
  const particles::UpdatePolicy strict = policy(0.9);
  std::vector<double> expected = test::log_evidences(run, model);
  const std::vector<double> nis = test::squared_distances(run, model);
  int inside = 0;
  for (std::size_t i = 0; i < 200; ++i) {
    const double excess = std::max(0.0, nis[i] - strict.gates[2]);
    inside += excess == 0.0 ? 1 : 0;
    expected[i] += 0.5 * excess;
  }
  ASSERT_GT(inside, 0);
  ASSERT_LT(inside, 200);
  const double sum = gaussian::log_sum_exp(expected.data(), 200);
  const particles::MixtureOutcome outcome = filter.update(model, strict);
  EXPECT_FALSE(outcome.accepted);
  EXPECT_TRUE(outcome.usable);
  for (std::size_t i = 0; i < 200; ++i) EXPECT_NEAR(particles[i].log_weight, expected[i] - sum, 1e-12);
  EXPECT_EQ(particles[0].belief.P, first.P);
  EXPECT_EQ(particles[0].belief.mean.T_map_base.p, first.mean.T_map_base.p);
}

TEST(ParticleFilter, TheGateCanBeOpened) {
  ParticleRun run({});
  run.filter().start(run.prior(), false);
  particles::UpdatePolicy open = policy(0.9);
  open.ignore_gate = true;
  EXPECT_TRUE(run.filter().update(PositionModel({50.0, 0.0}, 0.1), open).accepted);
  EXPECT_GT(run.filter().mixture().mean.T_map_base.p.x(), 40.0);
}

TEST(ParticleFilter, AnUpdateThatIsNotFiniteForOneIsAppliedToNone) {
  ParticleRun run(spread_settings(5));
  run.filter().start(run.prior(), true);
  const std::string before = run.bytes();
  EXPECT_FALSE(run.filter().update(PositionModel({std::nan(""), 0.0}, 0.1), policy()).usable);
  EXPECT_EQ(run.bytes(), before);
}

TEST(ParticleFilter, TheReportedInnovationIsTheMixtures) {
  ParticleRun run(spread_settings(30));
  run.filter().start(run.prior(), true);
  const Belief mixture = run.filter().mixture();
  const particles::MixtureOutcome outcome = run.filter().update(PositionModel({0.3, 0.1}, 0.5), policy());
  // Linear in the position, so the mixture's moments give it directly.
  const Eigen::Vector2d nu = Eigen::Vector2d(0.3, 0.1) - mixture.mean.T_map_base.p.head<2>();
  const Eigen::Matrix2d S = Eigen::MatrixXd(mixture.P).topLeftCorner<2, 2>() + 0.25 * Eigen::Matrix2d::Identity();
  EXPECT_LT((outcome.innovation - nu).norm(), 1e-12);
  EXPECT_LT((outcome.S - S).norm(), 1e-12);
  EXPECT_NEAR(outcome.nis, nu.dot(S.inverse() * nu), 1e-12);
}

TEST(ParticleFilter, ResamplesOnlyBelowTheThreshold) {
  for (const double threshold : {0.0, 0.5, 1.0}) {
    ParticleFilterSettings settings = spread_settings(50);
    settings.resample_threshold = threshold;
    ParticleRun run(settings);
    particles::ParticleFilter& filter = run.filter();
    filter.start(run.prior(), true);
    filter.resample_if_needed(0);
    EXPECT_EQ(filter.resamplings(), 0U) << "with equal weights N_eff is the number of particles";
    filter.update(PositionModel({0.5, 0.5}, 1.5), policy());
    const double share = filter.effective_sample_size() / 50.0;
    filter.resample_if_needed(0);
    EXPECT_EQ(filter.resamplings(), share < threshold ? 1U : 0U) << threshold << ": " << share;
    if (share < threshold) {
      EXPECT_NEAR(filter.effective_sample_size(), 50.0, 1e-9);
    }
  }
}

TEST(ParticleFilter, InflatesThePoseOnly) {
  ParticleRun run({});
  run.filter().start(run.prior(), false);
  run.filter().inflate_pose({.position = 4.0, .height = 9.0, .tilt = 9.0, .yaw = 0.5});
  EXPECT_EQ(run.filter().mixture().P.diagonal() - run.prior().P.diagonal(),
            (ErrorVector(6) << 4.0, 4.0, 0.5, 0.0, 0.0, 0.0).finished());
}

TEST(ParticleFilter, DrawsItsStartFromThePrior) {
  ParticleFilterSettings settings = spread_settings(2000);
  ParticleRun run(settings);
  run.filter().start(run.prior(), true);
  // Within plus between is the prior, up to the spread of 2000 draws: 5 σ of a variance, σ = √(2/2000) of it.
  for (int i = 0; i < 6; ++i) {
    EXPECT_NEAR(run.filter().mixture().P(i, i), run.prior().P(i, i),
                5.0 * std::sqrt(2.0 / 2000.0) * run.prior().P(i, i));
  }
}

TEST(ParticleFilter, OneParticleKeepsThePriorInsteadOfDrawing) {
  ParticleRun run({});
  run.filter().start(run.prior(), true);
  EXPECT_EQ(run.filter().mixture().P, run.prior().P);
  EXPECT_EQ(run.filter().mixture().mean.T_map_base.p, run.prior().mean.T_map_base.p);
}

TEST(ParticleFilter, ASavedFilterContinuesIdentically) {
  ParticleFilterSettings settings = spread_settings(20);
  settings.resample_threshold = 0.9;
  ParticleRun original(settings, {std::make_shared<test::ToyModule>()});
  original.filter().start(original.prior(), true);
  original.drive(0, 8);
  const std::string checkpoint = original.bytes();

  ParticleRun other(settings, {std::make_shared<test::ToyModule>()});
  other.filter().start(other.prior(), false);
  other.restore(checkpoint);
  EXPECT_EQ(other.bytes(), checkpoint);
  original.drive(8, 20);
  other.drive(8, 20);
  EXPECT_GT(original.filter().resamplings(), 0U);
  EXPECT_EQ(other.bytes(), original.bytes());
  EXPECT_EQ(other.filter().mixture().P, original.filter().mixture().P);
}

TEST(ParticleFilter, ACheckpointOfAnotherSizeIsRefused) {
  ParticleRun four(spread_settings(4));
  four.filter().start(four.prior(), false);
  ParticleRun five(spread_settings(5));
  five.filter().start(five.prior(), false);
  EXPECT_THROW(five.restore(four.bytes()), DataError);
}

}  // namespace
}  // namespace waymark
