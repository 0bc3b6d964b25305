// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "unit/sensors/sensor_bench.hpp"

namespace waymark {
namespace {

using sensor_test::make_sensor;
using sensor_test::measurement_of;
using sensor_test::refusal;
using sensor_test::SensorBench;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr double kExact = 1e-12;

SensorBench odometry(const std::string& yaml) { return SensorBench(make_sensor("odometry", yaml)); }

Measurement wheels(double left, double right, double t = 100.0) {
  WheelSpeeds speeds;
  speeds.left_mps = left;
  speeds.right_mps = right;
  return measurement_of(speeds, t);
}

Measurement steering(double speed, double angle) {
  WheelSteering wheel;
  wheel.speed_mps = speed;
  wheel.steering_rad = angle;
  return measurement_of(wheel);
}

Measurement twist(double v_x, double v_y, double w, double t = 100.0) {
  BodyTwist body;
  body.v_x_mps = v_x;
  body.v_y_mps = v_y;
  body.w_z_radps = w;
  return measurement_of(body, t);
}

Measurement increment(double interval, double x, double y, double yaw, double t = 100.0) {
  PoseIncrement step;
  step.interval_s = interval;
  step.x_m = x;
  step.y_m = y;
  step.yaw_rad = yaw;
  return measurement_of(step, t);
}

/// None of the errors that stay is a state, unless a test says so.
const std::string kStateless =
    "speed_scale_sigma: 0, curvature_sigma_per_m: 0, yaw_scale_sigma: 0, yaw_noise_rad_per_sqrt_s: [0, 0.01, 0.05]";
const std::string kDifferential = "{ model: differential, track_m: 0.5, " + kStateless + " }";

TEST(Odometry, DifferentialDriveTurnsTowardsTheSlowerWheel) {
  auto bench = odometry(kDifferential);
  const auto& model = bench.feed(wheels(0.9, 1.1));
  EXPECT_NEAR(model.residual[0], 1.0, kExact);
  EXPECT_NEAR(model.residual[1], 0.0, kExact);
  EXPECT_NEAR(model.residual[2], 0.2 / 0.5, kExact);
}

TEST(Odometry, OppositeWheelsTurnOnTheSpot) {
  auto bench = odometry(kDifferential);
  const auto& model = bench.feed(wheels(-0.25, 0.25));
  EXPECT_NEAR(model.residual[0], 0.0, kExact);
  EXPECT_NEAR(model.residual[2], 1.0, kExact);
}

// A car on a circle of radius R about a point to its left: the rear axle's centre moves at v, a wheel that is h to the
// left at v (R − h) / R.
TEST(Odometry, AckermannTakesTheEncoderWheelToTheAxlesCentre) {
  auto bench = odometry("{ model: ackermann, wheelbase_m: 2.83, encoder_left_m: 0.76 }");
  const double steer = 0.3;
  const double radius = 2.83 / std::tan(steer);
  const double wheel = 2.0 * (radius - 0.76) / radius;  // v = 2 m/s
  const auto& model = bench.feed(steering(wheel, steer));
  EXPECT_NEAR(model.residual[0], 2.0, kExact);
  EXPECT_NEAR(model.residual[1], 0.0, kExact);
  EXPECT_NEAR(model.residual[2], 2.0 / radius, kExact);
}

TEST(Odometry, AnEncoderOnTheRightIsOnTheOuterCircleOfALeftTurn) {
  auto bench = odometry("{ model: ackermann, wheelbase_m: 2.83, encoder_left_m: -0.76 }");
  EXPECT_LT(bench.feed(steering(2.0, 0.3)).residual[0], 2.0);
}

TEST(Odometry, AckermannGoesStraightWithTheWheelsStraight) {
  auto bench = odometry("{ model: ackermann, wheelbase_m: 2.83, encoder_left_m: 0.76 }");
  const auto& model = bench.feed(steering(3.0, 0.0));
  EXPECT_NEAR(model.residual[0], 3.0, kExact);
  EXPECT_NEAR(model.residual[2], 0.0, kExact);
}

TEST(Odometry, TheResidualIsTheDifferenceToTheState) {
  auto bench = odometry("{ model: twist }");
  bench.mean.v_base = {0.4, -0.1, 0.0};
  bench.mean.w_base = {0.0, 0.0, 0.2};
  const auto& model = bench.feed(twist(1.0, 0.05, -0.3));
  EXPECT_TRUE(model.residual.isApprox(Eigen::Vector3d(0.6, 0.15, -0.5), kExact));
}

SensorBench in_space(const std::string& yaml) {
  return SensorBench(make_sensor("odometry", yaml), StateLayout::Motion::spatial);
}

TEST(Odometry, InSpaceWheelsStayOnTheGround) {
  for (const std::string& yaml : {kDifferential, std::string("{ model: ackermann, wheelbase_m: 2.83 }")}) {
    auto bench = in_space(yaml);
    bench.mean.v_base = {1.0, 0.1, -0.3};
    const auto& model = yaml == kDifferential ? bench.feed(wheels(1.0, 1.0)) : bench.feed(steering(1.0, 0.0));
    ASSERT_EQ(model.residual.size(), 4) << yaml;
    EXPECT_NEAR(model.residual[0], 0.0, kExact);
    EXPECT_NEAR(model.residual[1], -0.1, kExact);
    EXPECT_NEAR(model.residual[3], 0.3, kExact) << "v_z of the base is observed as 0";
    // The density 0.05 · speed over the first interval, 0.1 s.
    EXPECT_NEAR(model.R(3, 3), 0.05 * 0.05 / 0.1, kExact);
  }
}

TEST(Odometry, TheMotionAlongZIsObservedAsTheYamlSays) {
  auto noisy = in_space("{ model: differential, track_m: 0.5, vertical_noise_m_per_sqrt_s: [0.1, 0.2] }");
  EXPECT_NEAR(noisy.feed(wheels(2.0, 2.0)).R(3, 3), 0.5 * 0.5 / 0.1, kExact);
  auto none = in_space("{ model: differential, track_m: 0.5, vertical_noise_m_per_sqrt_s: none }");
  EXPECT_EQ(none.feed(wheels(2.0, 2.0)).residual.size(), 3);
  // A ready-made twist can be that of a drone, so it needs the key.
  auto drone = in_space("{ model: twist }");
  EXPECT_EQ(drone.feed(twist(1.0, 0.0, 0.1)).residual.size(), 3);
  auto base = in_space("{ model: twist, vertical_noise_m_per_sqrt_s: [0.1, 0.2] }");
  EXPECT_EQ(base.feed(twist(1.0, 0.0, 0.1)).residual.size(), 4);
  auto step = in_space("{ model: increment, vertical_noise_m_per_sqrt_s: [0.1, 0.2] }");
  EXPECT_EQ(step.feed(increment(0.5, 0.5, 0.0, 0.1)).residual.size(), 4);
  // In the plane there is no v_z.
  auto flat = odometry("{ model: differential, track_m: 0.5, vertical_noise_m_per_sqrt_s: [0.1, 0.2] }");
  EXPECT_EQ(flat.feed(wheels(2.0, 2.0)).residual.size(), 3);
  EXPECT_THAT(refusal("odometry", "{ model: differential, track_m: 0.5, vertical_noise_m_per_sqrt_s: [-1, 0] }"),
              HasSubstr("vertical_noise_m_per_sqrt_s"));
  EXPECT_THAT(refusal("odometry", "{ model: differential, track_m: 0.5, vertical_noise_m_per_sqrt_s: some }"),
              HasSubstr("vertical_noise_m_per_sqrt_s"));
}

TEST(Odometry, AScaleErrorScalesSpeedAndRotationOfTheWheels) {
  auto bench = odometry("{ model: differential, track_m: 0.5, curvature_sigma_per_m: 0, yaw_scale_sigma: 0 }");
  bench.mean.block[0] = 0.1;
  const auto& model = bench.feed(wheels(0.9, 1.1));
  EXPECT_NEAR(model.residual[0], 1.1, kExact);
  EXPECT_NEAR(model.residual[2], 1.1 * 0.4, kExact);
}

TEST(Odometry, AScaleErrorLeavesARotationThatWasMeasuredOtherwiseAlone) {
  auto bench = odometry("{ model: twist, curvature_sigma_per_m: 0, yaw_scale_sigma: 0 }");
  bench.mean.block[0] = 0.1;
  const auto& model = bench.feed(twist(1.0, 0.0, 0.4));
  EXPECT_NEAR(model.residual[0], 1.1, kExact);
  EXPECT_NEAR(model.residual[2], 0.4, kExact);
}

TEST(Odometry, ACurvatureErrorTurnsWithTheDistance) {
  auto bench = odometry("{ model: twist, speed_scale_sigma: 0, curvature_sigma_per_m: 0.02, yaw_scale_sigma: 0 }");
  bench.mean.block[0] = 0.05;
  EXPECT_NEAR(bench.feed(twist(2.0, 0.0, 0.4)).residual[2], 0.4 + 0.1, kExact);
}

TEST(Odometry, AKnownErrorCorrectsTheReadingWithoutAState) {
  const std::string yaml =
      "{ model: differential, track_m: 0.5, speed_scale: 1.1, yaw_scale: 0.9, curvature_per_m: 0.05, " + kStateless +
      " }";
  auto bench = odometry(yaml);
  const auto& model = bench.feed(wheels(0.9, 1.1));
  EXPECT_NEAR(model.residual[0], 1.1, kExact);
  EXPECT_NEAR(model.residual[2], 1.1 * 0.9 * 0.4 + 0.05, kExact);
  const auto seen = make_sensor("odometry", yaml)->observed_motion(wheels(0.9, 1.1), nullptr);
  ASSERT_TRUE(seen);
  EXPECT_NEAR(seen->speed_mps, 1.1, kExact);
  EXPECT_NEAR(seen->yaw_rate_radps, 1.1 * 0.9 * 0.4 + 0.05, kExact);
}

TEST(Odometry, AKnownErrorIsWhereItsStateBegins) {
  const auto block =
      make_sensor("odometry", "{ model: twist, speed_scale: 1.1, yaw_scale: 0.9, curvature_per_m: 0.05 }")->block();
  ASSERT_EQ(block.size(), 3u);
  EXPECT_NEAR(block[0].initial, 0.1, kExact);
  EXPECT_NEAR(block[1].initial, 0.05, kExact);
  EXPECT_NEAR(block[2].initial, -0.1, kExact);
}

TEST(Odometry, AnErrorWithoutSigmaAndWalkIsNoState) {
  EXPECT_TRUE(make_sensor("odometry", kDifferential)->block().empty());
  const auto block = make_sensor("odometry",
                                 "{ model: twist, speed_scale_sigma: 0, speed_scale_walk_per_sqrt_m: 1e-4, "
                                 "curvature_sigma_per_m: 0, yaw_scale_sigma: 0.03 }")
                         ->block();
  ASSERT_EQ(block.size(), 2u);
  EXPECT_EQ(block[0].walk_per_sqrt_m, 1e-4);
  EXPECT_EQ(block[1].initial_sigma, 0.03);
}

const std::string kLosesSpeedInTurns = "{ model: twist, turn_loss_m: 0.1, " + kStateless + " }";

TEST(Odometry, ALossInTurnsIsTakenOffTheSpeedButNotOffTheRate) {
  auto bench = odometry(kLosesSpeedInTurns);
  for (const double way : {1.0, -1.0}) {
    for (const double side : {1.0, -1.0}) {
      const auto& model = bench.feed(twist(way * 0.09, 0.0, side * 0.4));
      EXPECT_NEAR(model.residual[0], way * 0.05, kExact);
      EXPECT_NEAR(model.residual[2], side * 0.4, kExact);
    }
  }
  const auto seen = make_sensor("odometry", kLosesSpeedInTurns)->observed_motion(twist(0.09, 0.0, 0.4), nullptr);
  ASSERT_TRUE(seen);
  EXPECT_NEAR(seen->speed_mps, 0.05, kExact);
}

TEST(Odometry, WhatLosesSpeedInTurnsStopsAndDoesNotReverse) {
  auto bench = odometry(kLosesSpeedInTurns);
  EXPECT_NEAR(bench.feed(twist(0.01, 0.0, 0.4)).residual[0], 0.0, kExact);
  EXPECT_NEAR(bench.feed(twist(0.0, 0.0, 0.4)).residual[0], 0.0, kExact);
}

TEST(Odometry, TheErrorOfTheLossInTurnsIsAState) {
  auto bench = odometry("{ model: twist, turn_loss_m: 0.07, turn_loss_sigma_m: 0.05, " + kStateless + " }");
  bench.mean.block[0] = 0.1;
  const auto& model = bench.feed(twist(0.09, 0.0, -0.4));
  EXPECT_NEAR(model.residual[0], 0.05, kExact);
  EXPECT_NEAR(model.get_block()(0, 0), 0.4, kExact);
  EXPECT_FALSE(model.estimates_block());
}

// Densities a + b·|v| (+ c·|ω|); the variance of a sample is density² / Δt.
const std::string kNoisyTwist =
    "{ model: twist, speed_noise_m_per_sqrt_s: [0.02, 0.05], lateral_noise_m_per_sqrt_s: [0.01, 0.1],"
    " yaw_noise_rad_per_sqrt_s: [0.001, 0.01, 0.05] }";

TEST(Odometry, ByDefaultTheErrorsOfAUsualVehicleAreStates) {
  const std::pair<std::string, double> curvature[] = {{"{ model: differential, track_m: 0.5 }", 0.05},
                                                      {"{ model: ackermann, wheelbase_m: 2.5 }", 0.008},
                                                      {"{ model: twist }", 0.03},
                                                      {"{ model: increment }", 0.03}};
  for (const auto& [yaml, sigma] : curvature) {
    const auto block = make_sensor("odometry", yaml)->block();
    ASSERT_EQ(block.size(), 3u) << yaml;
    EXPECT_EQ(block[0].initial_sigma, 0.02);
    EXPECT_NEAR(block[1].initial_sigma, sigma, kExact) << yaml;
    EXPECT_EQ(block[2].initial_sigma, 0.03);
  }
}

TEST(Odometry, NoiseGrowsWithThePredictedMotionAsTheYamlSays) {
  auto bench = odometry(kNoisyTwist);
  bench.mean.v_base = {2.0, 0.0, 0.0};
  bench.mean.w_base = {0.0, 0.0, 0.4};
  bench.feed(twist(2.1, 0.0, 0.5, 100.0));
  const auto& model = bench.feed(twist(2.1, 0.0, 0.5, 100.25));
  EXPECT_NEAR(model.R(0, 0), 0.12 * 0.12 / 0.25, kExact);
  EXPECT_NEAR(model.R(1, 1), 0.21 * 0.21 / 0.25, kExact);
  EXPECT_NEAR(model.R(2, 2), 0.041 * 0.041 / 0.25, kExact);
}

TEST(Odometry, AReadingsOwnErrorDoesNotChangeItsWeight) {
  auto low = odometry(kNoisyTwist);
  auto high = odometry(kNoisyTwist);
  for (auto* bench : {&low, &high}) {
    bench->mean.v_base = {2.0, 0.0, 0.0};
    bench->feed(twist(2.0, 0.0, 0.0, 100.0));
  }
  EXPECT_EQ(low.feed(twist(1.9, 0.0, -0.1, 100.1)).R, high.feed(twist(2.1, 0.0, 0.1, 100.1)).R);
}

TEST(Odometry, AfterAGapNoiseGrowsWithTheReading) {
  auto bench = odometry(kNoisyTwist);  // the prediction, at rest, is worth nothing by then
  bench.feed(twist(2.0, 0.0, 0.4, 100.0));
  EXPECT_NEAR(bench.feed(twist(2.0, 0.0, 0.4, 110.0)).R(0, 0), 0.12 * 0.12 / 0.5, kExact);
}

TEST(Odometry, TwiceTheRateGivesEverySampleTwiceTheVariance) {
  auto slow = odometry(kDifferential);
  auto fast = odometry(kDifferential);
  slow.feed(wheels(1.0, 1.0, 100.0));
  fast.feed(wheels(1.0, 1.0, 100.0));
  const double at_10_hz = slow.feed(wheels(1.0, 1.0, 100.1)).R(0, 0);
  const double at_20_hz = fast.feed(wheels(1.0, 1.0, 100.05)).R(0, 0);
  EXPECT_NEAR(at_20_hz / at_10_hz, 2.0, 1e-9);
}

TEST(Odometry, AGapInTheLogCountsAsMaxInterval) {
  auto bench =
      odometry("{ model: differential, track_m: 0.5, max_interval_s: 0.4, speed_noise_m_per_sqrt_s: [0.1, 0.0] }");
  bench.feed(wheels(1.0, 1.0, 100.0));
  EXPECT_NEAR(bench.feed(wheels(1.0, 1.0, 160.0)).R(0, 0), 0.01 / 0.4, kExact);
}

TEST(Odometry, TwoSamplesWithOneStampStillHaveFiniteNoise) {
  auto bench = odometry(kDifferential);
  bench.feed(wheels(1.0, 1.0, 100.0));
  EXPECT_TRUE(bench.feed(wheels(1.0, 1.0, 100.0)).R.allFinite());
}

TEST(Odometry, NoiseThatVanishesWithSpeedStaysPositive) {
  auto bench =
      odometry("{ model: twist, lateral_noise_m_per_sqrt_s: [0.0, 0.1], yaw_noise_rad_per_sqrt_s: [0, 0.01, 0.05] }");
  const auto& model = bench.feed(twist(0.0, 0.0, 0.0));
  EXPECT_GT(model.R.diagonal().minCoeff(), 0.0);
}

TEST(Odometry, ReportsStandstillBelowBothThresholds) {
  auto bench = odometry("{ model: twist, still_speed_mps: 0.02, still_rate_radps: 0.03 }");
  bench.feed(twist(0.019, 0.0, -0.029));
  EXPECT_EQ(bench.motion(), UpdateList::Motion::still);
}

TEST(Odometry, ReportsMotionAboveEitherThreshold) {
  auto bench = odometry("{ model: twist, still_speed_mps: 0.02, still_rate_radps: 0.03 }");
  bench.feed(twist(-0.021, 0.0, 0.0));
  EXPECT_EQ(bench.motion(), UpdateList::Motion::moving);
  bench.feed(twist(0.0, 0.0, -0.031));
  EXPECT_EQ(bench.motion(), UpdateList::Motion::moving);
}

TEST(Odometry, IsAMotionSourceAndNotAbsolute) {
  const auto sensor = make_sensor("odometry", kDifferential);
  EXPECT_TRUE(sensor->traits().is_motion_source);
  EXPECT_FALSE(sensor->traits().is_absolute);
}

TEST(Odometry, RefusesASpeedWithoutNoise) {
  EXPECT_THAT(refusal("odometry", "{ model: twist, speed_noise_m_per_sqrt_s: [0, 0] }"),
              HasSubstr("speed_noise_m_per_sqrt_s"));
}

TEST(Odometry, RefusesNegativeNoise) {
  EXPECT_THAT(refusal("odometry", "{ model: twist, speed_noise_m_per_sqrt_s: [0.1, -0.1] }"),
              HasSubstr("speed_noise_m_per_sqrt_s"));
  EXPECT_THAT(refusal("odometry", "{ model: twist, yaw_noise_rad_per_sqrt_s: [0.1, 0, -1] }"),
              HasSubstr("yaw_noise_rad_per_sqrt_s"));
  EXPECT_THAT(refusal("odometry", "{ model: twist, speed_scale_sigma: -0.1 }"), HasSubstr("speed_scale_sigma"));
}

TEST(Odometry, RefusesAnUnknownModelAndListsTheKnownOnes) {
  EXPECT_THAT(refusal("odometry", "{ model: tricycle }"),
              AllOf(HasSubstr("tricycle"), HasSubstr("differential"), HasSubstr("ackermann"), HasSubstr("twist")));
}

TEST(Odometry, RefusesAMissingOrZeroGeometry) {
  EXPECT_THAT(refusal("odometry", "{ model: differential }"), HasSubstr("track_m"));
  EXPECT_THAT(refusal("odometry", "{ model: ackermann, wheelbase_m: 0 }"), HasSubstr("wheelbase_m"));
}

TEST(Odometry, RefusesAKeyOfAnotherModel) {
  EXPECT_THAT(refusal("odometry", "{ model: twist, track_m: 0.5 }"), HasSubstr("track_m"));
}

TEST(Odometry, RefusesAPayloadOfAnotherModel) {
  const auto sensor = make_sensor("odometry", kDifferential);
  const StateLayout layout(StateLayout::Motion::planar, {});
  const Belief belief;
  UpdateList updates;
  EXPECT_THROW(sensor->process(twist(1.0, 0.0, 0.0), {belief, layout, nullptr, nullptr, false}, updates), DataError);
}

// A quarter turn to the left on a circle of radius 2 m ends 2 m ahead and 2 m to the left; the arc is pi m long.
TEST(Odometry, AnIncrementIsTheTwistOfItsArc) {
  auto bench = odometry("{ model: increment }");
  const double quarter = 0.5 * std::numbers::pi;
  const auto& model = bench.feed(increment(2.0, 2.0, 2.0, quarter));
  EXPECT_NEAR(model.residual[0], 0.5 * std::numbers::pi, kExact);
  EXPECT_NEAR(model.residual[1], 0.0, kExact);
  EXPECT_NEAR(model.residual[2], 0.5 * quarter, kExact);
  EXPECT_TRUE(bench.twist_reset().has_value());
  EXPECT_EQ(bench.motion(), UpdateList::Motion::moving);
  auto sideways = odometry("{ model: increment }");
  EXPECT_NEAR(sideways.feed(increment(0.5, 0.0, 0.1, 0.0)).residual[1], 0.2, kExact);
}

// Over two intervals of half the time the variances of the motion add up to the same.
TEST(Odometry, TheNoiseOfAnIncrementIsThatOfItsDensities) {
  auto bench = odometry(
      "{ model: increment, speed_noise_m_per_sqrt_s: [0.01, 0.1], lateral_noise_m_per_sqrt_s: [0.02, 0.0],"
      " yaw_noise_rad_per_sqrt_s: [0.0, 0.03, 0.0] }");
  const auto motion_variance = [&](double interval) -> Eigen::Vector3d {
    return bench.feed(increment(interval, 0.5 * interval, 0.0, 0.0)).R.diagonal() * interval * interval;
  };
  const Eigen::Vector3d whole = motion_variance(2.0);
  EXPECT_TRUE(whole.isApprox(2.0 * Eigen::Vector3d(0.06 * 0.06, 0.02 * 0.02, 0.015 * 0.015), 1e-9)) << whole;
  EXPECT_TRUE(whole.isApprox(2.0 * motion_variance(1.0), 1e-9));
  // The same motion in a hundredth of the time, by a stamp that jitters, counts as one in a tenth of a second.
  const Eigen::Vector3d burst = bench.feed(increment(0.001, 0.05, 0.0, 0.0)).R.diagonal() * 1e-6;
  EXPECT_TRUE(burst.isApprox(motion_variance(0.1), 1e-9)) << burst;
}

// A robot that needed four minutes for half a metre and half a radian stood most of the time.
TEST(Odometry, AnIncrementHasNoNoiseForTheTimeThatTheRobotStood) {
  auto bench = odometry(
      "{ model: increment, speed_noise_m_per_sqrt_s: [0.04, 0.1], yaw_noise_rad_per_sqrt_s: [0.06, 0.0, 0.2],"
      " max_interval_s: 1.0 }");
  const auto motion_variance = [&](double interval, double x, double yaw) -> Eigen::Vector3d {
    return bench.feed(increment(interval, x, 0.0, yaw)).R.diagonal() * interval * interval;
  };
  const Eigen::Vector3d slow = motion_variance(10.0, 0.5, 0.5);
  EXPECT_TRUE(motion_variance(240.0, 0.5, 0.5).isApprox(slow, 0.02)) << slow;
  EXPECT_LT(slow.z(), 10.0 * 0.08 * 0.08 * 1.02);
  // Where it moved all the time, and in a short interval, all of it counts.
  EXPECT_NEAR(motion_variance(10.0, 5.0, 0.0).z(), 10.0 * 0.06 * 0.06, 1e-9);
  EXPECT_NEAR(motion_variance(0.8, 0.01, 0.0).z(), 0.8 * 0.06 * 0.06, 1e-9);
  // Without any motion an interval counts as the longest that a sample stands for.
  EXPECT_NEAR(motion_variance(240.0, 0.0, 0.0).z(), 0.06 * 0.06, 1e-9);
}

TEST(Odometry, AnIncrementNeedsAnInterval) {
  auto bench = odometry("{ model: increment }");
  EXPECT_THROW(bench.feed(increment(0.0, 0.1, 0.0, 0.0)), DataError);
  EXPECT_THROW(bench.feed(increment(std::nan(""), 0.1, 0.0, 0.0)), DataError);
}

TEST(Odometry, ShowsItsMotionToTheDiagnosisButNoRotationThatIsDeclaredToBeNoise) {
  const auto measured = make_sensor("odometry", "{ model: twist }")->observed_motion(twist(1.0, 0.0, 0.4), nullptr);
  ASSERT_TRUE(measured);
  EXPECT_NEAR(measured->speed_mps, 1.0, kExact);
  EXPECT_NEAR(measured->yaw_rate_radps, 0.4, kExact);
  const auto unmeasured = make_sensor("odometry", "{ model: twist, yaw_noise_rad_per_sqrt_s: [10, 0, 0] }")
                              ->observed_motion(twist(1.0, 0.0, 0.0), nullptr);
  ASSERT_TRUE(unmeasured);
  EXPECT_NEAR(unmeasured->speed_mps, 1.0, kExact);
  EXPECT_TRUE(std::isnan(unmeasured->yaw_rate_radps));
}

}  // namespace
}  // namespace waymark
