// SPDX-License-Identifier: Apache-2.0
#include "attitude_filter.hpp"

#include <gtest/gtest.h>

#include "imu_simulator.hpp"

namespace waymark::imu {
namespace {

TEST(AttitudeFilter, FindsItsAttitudeWithinTheLevelling) {
  AttitudeFilter filter;
  ImuSimulator sim;
  sim.q_map_sensor = so3::from_rpy(0.3, -0.5, 2.0);
  filter.process(sim.stamp(), sim.sample());
  EXPECT_FALSE(filter.levelled());
  EXPECT_LT(error_of(filter, sim).norm(), 1e-9) << "of the first sample alone";
  sim.advance();
  sim.run(filter, filter.settings().levelling_s + 0.1);
  EXPECT_TRUE(filter.levelled());
  EXPECT_TRUE(filter.knows_tilt());
  EXPECT_TRUE(filter.knows_heading());
  EXPECT_LT(error_of(filter, sim).norm(), 1e-6);
  EXPECT_NEAR((filter.levelling_force() - sim.sample().f_sensor).norm(), 0.0, 1e-9);
}

TEST(AttitudeFilter, LevelsWhileItTurns) {
  AttitudeFilter filter;
  ImuSimulator sim;
  sim.rate = waving;
  sim.q_map_sensor = so3::from_rpy(-0.4, 0.2, -1.0);
  sim.run(filter, filter.settings().levelling_s + 0.1);
  ASSERT_TRUE(filter.levelled());
  // The truth stands one step after the filter.
  EXPECT_LT(error_of(filter, sim).norm(), 1.1 * sim.dt * sim.rate(sim.t).norm());
}

TEST(AttitudeFilter, TheFieldPointsToTheDeclination) {
  AttitudeSettings settings;
  settings.declination = 5.0 * kDegree;
  AttitudeFilter filter(settings);
  ImuSimulator sim;
  sim.q_map_sensor = so3::from_rpy(0.1, 0.2, 1.0);
  sim.field = [](double) {  // 5° east of north
    return Eigen::Vector3d(20e-6 * std::sin(5.0 * kDegree), 20e-6 * std::cos(5.0 * kDegree), -45e-6);
  };
  sim.run(filter, 10.0);
  EXPECT_LT(error_of(filter, sim).norm(), 1e-6);
}

TEST(AttitudeFilter, FollowsAConstantRotation) {
  AttitudeFilter filter;
  ImuSimulator sim;
  sim.rate = [](double) { return Eigen::Vector3d(0.4, -0.8, 1.1); };
  double worst = 0.0;
  sim.run(filter, 60.0, [&] { worst = std::max(worst, error_of(filter, sim).norm()); });
  EXPECT_LT(worst, 0.02 * kDegree);
  EXPECT_LT((filter.angular_rate() - sim.rate(0.0)).norm(), 1e-4);
}

TEST(AttitudeFilter, FollowsARotationThatChanges) {
  AttitudeFilter filter;
  ImuSimulator sim;
  sim.rate = waving;
  double worst = 0.0;
  sim.run(filter, 60.0, [&] { worst = std::max(worst, error_of(filter, sim).norm()); });
  EXPECT_LT(worst, 0.05 * kDegree);
}

TEST(AttitudeFilter, FindsTheBiasAtRest) {
  AttitudeFilter filter;
  ImuSimulator sim;
  sim.bias = Eigen::Vector3d(1.0, -0.7, 0.5) * kDegree;
  sim.gyro_sigma = 0.1 * kDegree;
  sim.force_sigma = 0.05;
  sim.has_field = false;  // so the third axis has nothing but the rest
  sim.run(filter, 10.0);
  EXPECT_TRUE(filter.resting());
  EXPECT_LT((filter.gyro_bias() - sim.bias).norm(), 0.05 * kDegree);
  EXPECT_LT(std::sqrt(filter.covariance()(5, 5)), 0.05 * kDegree);
}

TEST(AttitudeFilter, FindsTheBiasInMotion) {
  AttitudeFilter filter;
  ImuSimulator sim;
  sim.rate = waving;
  sim.bias = Eigen::Vector3d(0.5, -0.7, 0.4) * kDegree;
  sim.gyro_sigma = 0.1 * kDegree;
  sim.force_sigma = 0.05;
  sim.run(filter, 120.0, [&] { EXPECT_FALSE(filter.resting()); });
  EXPECT_LT((filter.gyro_bias() - sim.bias).norm(), 0.1 * kDegree);
  EXPECT_LT(tilt_error(filter, sim), 0.2 * kDegree + sim.dt * 3.0) << "one step of motion allowed";
}

TEST(AttitudeFilter, SlowMotionIsNoRest) {
  AttitudeFilter filter;
  ImuSimulator sim;
  sim.rate = [](double t) { return Eigen::Vector3d(0.0, 0.0, 0.2 * std::sin(t)); };
  bool rested = false;
  sim.run(filter, 30.0, [&] { rested = rested || filter.resting(); });
  EXPECT_FALSE(rested);
}

TEST(AttitudeFilter, ASlowTurnAfterARestIsNotLearnedAsBias) {
  AttitudeFilter filter;
  ImuSimulator sim;
  sim.has_field = false;
  sim.rate = [](double t) { return Eigen::Vector3d(0.0, 0.0, t > 5.0 && t < 11.0 ? 1.5 * kDegree : 0.0); };
  sim.run(filter, 5.0);
  const double start = error_of(filter, sim).z();
  sim.run(filter, 10.0);
  EXPECT_NEAR(error_of(filter, sim).z(), start, 1.0 * kDegree) << "of 9 degrees";
}

TEST(AttitudeFilter, ABiasThatJumpsIsLearnedWhenTheRestLasts) {
  AttitudeFilter filter;
  ImuSimulator sim;
  sim.has_field = false;
  sim.run(filter, 20.0);
  sim.bias.z() = 1.0 * kDegree;
  sim.run(filter, 9.0);
  EXPECT_LT(filter.gyro_bias().z(), 0.5 * kDegree);
  sim.run(filter, 60.0);
  EXPECT_NEAR(filter.gyro_bias().z(), sim.bias.z(), 0.1 * kDegree);
}

TEST(AttitudeFilter, FindsTheHorizontalBiasThroughGravityAlone) {
  AttitudeSettings settings;
  settings.rest_s = 1e9;
  AttitudeFilter filter(settings);
  ImuSimulator sim;
  sim.bias = Eigen::Vector3d(0.5, 0.5, 0.0) * kDegree;
  sim.run(filter, 60.0);
  EXPECT_LT((filter.gyro_bias() - sim.bias).norm(), 0.05 * kDegree);
  EXPECT_LT(tilt_error(filter, sim), 0.05 * kDegree);
}

TEST(AttitudeFilter, SwingingDoesNotTiltIt) {
  const auto worst_tilt = [](const AttitudeSettings& settings) {
    AttitudeFilter filter(settings);
    ImuSimulator sim;
    sim.acceleration = [](double t) {
      return t < 3.0 ? Eigen::Vector3d(0.0, 0.0, 0.0)
                     : Eigen::Vector3d(4.0 * std::sin(7.0 * t), 3.0 * std::sin(5.0 * t), 0);
    };
    double worst = 0.0;
    sim.run(filter, 60.0, [&] { worst = std::max(worst, tilt_error(filter, sim)); });
    return worst;
  };
  AttitudeSettings credulous;
  credulous.tilt_per_motion = 0.0;
  credulous.accelerometer_time_s = 0.02;
  credulous.acceleration_time_s = 0.0;
  EXPECT_LT(worst_tilt({}), 0.5 * kDegree);
  EXPECT_GT(worst_tilt(credulous), 2.0 * kDegree) << "the motion is too gentle to show anything";
}

TEST(AttitudeFilter, ALongAccelerationCountsLessTheMoreItShows) {
  // 4 m/s² for 5 s: no low-pass averages this out, but the magnitude is 0.8 m/s² too large.
  const auto tilt_after = [](double tilt_per_magnitude) {
    AttitudeSettings settings;
    settings.tilt_per_magnitude = tilt_per_magnitude;
    AttitudeFilter filter(settings);
    ImuSimulator sim;
    sim.acceleration = [](double t) { return Eigen::Vector3d(t > 10.0 ? 4.0 : 0.0, 0.0, 0.0); };
    sim.run(filter, 15.0);
    return tilt_error(filter, sim);
  };
  const double adaptive = tilt_after(AttitudeSettings{}.tilt_per_magnitude);
  EXPECT_LT(adaptive, 4.0 * kDegree);
  EXPECT_LT(adaptive, 0.7 * tilt_after(0.0));
}

TEST(AttitudeFilter, TheRateOfTheSamplesDoesNotMatter) {
  std::vector<Eigen::Quaterniond> ends;
  std::vector<double> sigmas;
  for (const double dt : {0.0025, 0.01, 0.02}) {
    AttitudeFilter filter;
    ImuSimulator sim;
    sim.dt = dt;
    sim.bias = Eigen::Vector3d(0.3, -0.2, 0.1) * kDegree;
    sim.rate = waving;
    sim.acceleration = [](double t) { return Eigen::Vector3d(2.0 * std::sin(3.0 * t), 0.0, 0.0); };
    sim.run(filter, 40.0 + 0.5 * dt);
    ends.push_back(filter.q_map_sensor());
    sigmas.push_back(std::sqrt(filter.covariance()(0, 0)));
  }
  for (std::size_t i = 1; i < ends.size(); ++i) {
    // The last samples are not at the same time: up to 0.02 s of motion between them.
    EXPECT_LT(ends[i].angularDistance(ends[0]), 0.02 * waving(40.0).norm() + 0.05 * kDegree);
    EXPECT_NEAR(sigmas[i], sigmas[0], 0.05 * sigmas[0]);
  }
}

TEST(AttitudeFilter, SigmaOfAttitudeAndBiasIsHonestForNoiseOfTheModel) {
  constexpr int kRuns = 60;
  double attitude_nees = 0.0;
  double bias_nees = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    AttitudeSettings settings;
    settings.gyro_noise_per_rate = 0.0;
    AttitudeFilter filter(settings);
    ImuSimulator sim;
    sim.random.seed(static_cast<std::uint64_t>(run) + 1);
    std::normal_distribution<double> normal(0.0, settings.bias_sigma);
    for (int i = 0; i < 3; ++i) sim.bias(i) = normal(sim.random);
    sim.rate = waving;
    sim.gyro_sigma = settings.gyro_noise / std::sqrt(sim.dt);
    sim.force_sigma = 0.1;
    sim.run(filter, 20.0);
    filter.process(sim.stamp(), sim.sample());
    const Eigen::Vector2d tilt = error_of(filter, sim).head<2>();
    attitude_nees += tilt.dot(filter.covariance().topLeftCorner<2, 2>().inverse() * tilt) / kRuns;
    const Eigen::Vector3d bias = sim.bias - filter.gyro_bias();
    bias_nees += bias.dot(filter.covariance().bottomRightCorner<3, 3>().inverse() * bias) / kRuns;
  }
  // The noise of force and field is given as correlated, and larger: σ may be pessimistic, not optimistic.
  EXPECT_LT(attitude_nees, 2.0);
  EXPECT_GT(attitude_nees, 0.05);
  EXPECT_LT(bias_nees, 3.0);
  EXPECT_GT(bias_nees, 0.1);
}

}  // namespace
}  // namespace waymark::imu
