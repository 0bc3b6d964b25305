// SPDX-License-Identifier: Apache-2.0
// Devices with fewer axes, bad samples, gaps, saturation, mounting, checkpoints.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "attitude_filter.hpp"
#include "imu_simulator.hpp"
#include "low_pass.hpp"

namespace waymark::imu {
namespace {

TEST(Modes, SixAxesKnowRollAndPitchAndKeepTheHeadingOfTheStart) {
  AttitudeFilter filter;
  ImuSimulator sim;
  sim.has_field = false;
  sim.q_map_sensor = so3::from_rpy(0.2, -0.3, 0.0);
  // Begins and ends gently: a jump of the rate costs every filter half a sample of it.
  sim.rate = [](double t) -> Eigen::Vector3d {
    return t < 3.0 || t > 63.0 ? Eigen::Vector3d(0.0, 0.0, 0.0)
                               : Eigen::Vector3d(std::sin(std::numbers::pi * (t - 3.0) / 60.0) * waving(t));
  };
  sim.run(filter, 3.0);
  EXPECT_TRUE(filter.knows_tilt());
  EXPECT_FALSE(filter.knows_heading());
  const double start = error_of(filter, sim).z();
  sim.run(filter, 61.0);
  EXPECT_LT(tilt_error(filter, sim), 0.1 * kDegree);
  EXPECT_NEAR(error_of(filter, sim).z(), start, 0.5 * kDegree);
  EXPECT_EQ(filter.counts().without_field, filter.counts().used);
}

TEST(Modes, AGyroAloneIntegratesAndLearnsItsBiasAtRest) {
  AttitudeFilter filter;
  ImuSimulator sim;
  sim.has_force = sim.has_field = false;
  sim.bias = Eigen::Vector3d(0.5, -0.5, 1.0) * kDegree;
  sim.run(filter, 10.0);
  EXPECT_TRUE(filter.levelled());
  EXPECT_FALSE(filter.knows_tilt());
  EXPECT_TRUE(filter.resting());
  EXPECT_LT((filter.gyro_bias() - sim.bias).norm(), 0.01 * kDegree);
  const Eigen::Quaterniond before = filter.q_map_sensor();
  const Eigen::Quaterniond truth_before = sim.q_map_sensor;
  const double sigma = std::sqrt(filter.covariance()(0, 0));
  sim.rate = [](double t) { return t < 15.0 ? Eigen::Vector3d(0.3, 0.2, 0.4) : Eigen::Vector3d(0.0, 0.0, 0.0); };
  sim.run(filter, 6.0);
  const Eigen::Quaterniond turned = before.conjugate() * filter.q_map_sensor();
  EXPECT_LT(turned.angularDistance(truth_before.conjugate() * sim.q_map_sensor), 0.5 * kDegree);
  EXPECT_GT(std::sqrt(filter.covariance()(0, 0)), sigma) << "nothing bounds the drift";
}

TEST(Modes, AnAccelerometerThatWakesUpLaterLevels) {
  AttitudeFilter filter;
  ImuSimulator sim;
  sim.has_force = sim.has_field = false;
  sim.q_map_sensor = so3::from_rpy(0.5, 0.0, 0.3);
  sim.run(filter, 5.0);
  EXPECT_FALSE(filter.knows_tilt());
  sim.has_force = true;
  sim.run(filter, 2.0);
  EXPECT_TRUE(filter.knows_tilt());
  EXPECT_LT(tilt_error(filter, sim), 0.1 * kDegree);
  sim.has_field = true;
  sim.run(filter, 2.0);
  EXPECT_TRUE(filter.knows_heading());
  EXPECT_LT(error_of(filter, sim).norm(), 0.1 * kDegree);
}

TEST(Modes, AMagnetometerMayBeSlower) {
  AttitudeFilter filter;
  ImuSimulator sim;
  sim.rate = waving;
  sim.q_map_sensor = so3::from_rpy(0.2, -0.3, 1.0);
  int count = 0;
  double worst = 0.0;
  sim.run(filter, 30.0, [&] {
    sim.has_field = ++count % 10 == 0;
    if (count > 200) worst = std::max(worst, error_of(filter, sim).norm());
  });
  EXPECT_TRUE(filter.knows_heading());
  EXPECT_LT(worst, 0.1 * kDegree);
}

TEST(Modes, ASampleWithoutRateIsIgnoredAndCounted) {
  AttitudeFilter clean;
  AttitudeFilter soiled;
  ImuSimulator sim;
  sim.rate = waving;
  sim.gyro_sigma = 0.01;
  int bad = 0;
  for (int i = 0; i < 1000; ++i) {
    const ImuSample sample = sim.sample();
    if (i % 7 == 3) {
      ImuSample broken = sample;
      broken.w_sensor(i % 3) = i % 2 == 0 ? ImuSample::kUnknown : std::numeric_limits<double>::infinity();
      EXPECT_FALSE(soiled.process(sim.stamp(), broken));
      ++bad;
    } else {
      EXPECT_TRUE(clean.process(sim.stamp(), sample));
      EXPECT_TRUE(soiled.process(sim.stamp(), sample));
    }
    sim.advance();
  }
  EXPECT_EQ(soiled.counts().without_rate, static_cast<std::uint64_t>(bad));
  EXPECT_EQ(soiled.q_map_sensor().coeffs(), clean.q_map_sensor().coeffs());
  EXPECT_EQ(soiled.covariance(), clean.covariance());
}

TEST(Modes, BadForceAndFieldAreSkippedAndCounted) {
  AttitudeFilter filter;
  ImuSimulator sim;
  sim.rate = waving;
  double worst = 0.0;
  for (int i = 0; i < 3000; ++i) {
    ImuSample sample = sim.sample();
    if (i % 5 == 1) sample.f_sensor.y() = ImuSample::kUnknown;
    if (i % 4 == 1) sample.m_sensor.setZero();
    EXPECT_TRUE(filter.process(sim.stamp(), sample));
    worst = std::max(worst, error_of(filter, sim).norm());
    sim.advance();
  }
  EXPECT_EQ(filter.counts().without_force, 600u);
  EXPECT_EQ(filter.counts().without_field, 750u);
  EXPECT_LT(worst, 0.1 * kDegree);
  EXPECT_TRUE(filter.covariance().allFinite());
}

TEST(Modes, ASampleThatIsNotLaterIsIgnored) {
  AttitudeFilter filter;
  ImuSimulator sim;
  sim.rate = waving;
  sim.run(filter, 3.0);
  const Eigen::Quaterniond before = filter.q_map_sensor();
  sim.t -= sim.dt;
  EXPECT_FALSE(filter.process(sim.stamp(), sim.sample()));
  sim.t -= 1.0;
  EXPECT_FALSE(filter.process(sim.stamp(), sim.sample()));
  EXPECT_EQ(filter.counts().out_of_order, 2u);
  EXPECT_EQ(filter.q_map_sensor().coeffs(), before.coeffs());
}

TEST(Modes, AfterALongGapItLevelsAgainAndKeepsTheBias) {
  AttitudeFilter filter;
  ImuSimulator sim;
  sim.bias = Eigen::Vector3d(1.0, 0.5, -0.5) * kDegree;
  sim.run(filter, 10.0);
  const Eigen::Vector3d bias = filter.gyro_bias();
  sim.t += 5.0;
  sim.q_map_sensor = so3::from_rpy(-0.8, 0.4, 2.5);
  filter.process(sim.stamp(), sim.sample());
  EXPECT_FALSE(filter.levelled());
  EXPECT_EQ(filter.counts().gaps, 1u);
  EXPECT_FALSE(filter.resting());
  EXPECT_GT(std::sqrt(filter.covariance()(2, 2)), 90.0 * kDegree);
  EXPECT_LT((filter.gyro_bias() - bias).norm(), 1e-3 * kDegree);
  sim.advance();
  sim.run(filter, 2.0);
  EXPECT_TRUE(filter.levelled());
  EXPECT_LT(error_of(filter, sim).norm(), 0.1 * kDegree);
}

TEST(Modes, AShortGapIsBridged) {
  AttitudeFilter filter;
  ImuSimulator sim;
  sim.rate = [](double) { return Eigen::Vector3d(0.3, 0.5, -0.7); };
  sim.run(filter, 10.0);
  for (int i = 0; i < 30; ++i) sim.advance();
  filter.process(sim.stamp(), sim.sample());
  EXPECT_EQ(filter.counts().gaps, 0u);
  EXPECT_LT(error_of(filter, sim).norm(), 0.1 * kDegree);
}

TEST(Modes, AGyroAtTheEndOfItsRangeLosesTheAttitudeForAMoment) {
  const auto error_after = [](bool detect) {
    AttitudeSettings settings;
    if (!detect) settings.saturation_rate = 1e9;
    AttitudeFilter filter(settings);
    ImuSimulator sim;
    sim.range = 6.0;
    sim.rate = [](double t) {
      return Eigen::Vector3d(t > 10.0 && t < 10.5 ? 10.0 * std::sin(2.0 * std::numbers::pi * (t - 10.0)) : 0.0, 0.0,
                             0.0);
    };
    sim.run(filter, 11.0);
    EXPECT_EQ(filter.counts().saturated > 0, detect);
    sim.run(filter, 1.0);
    return error_of(filter, sim).norm();
  };
  EXPECT_LT(error_after(true), 2.0 * kDegree);
  EXPECT_GT(error_after(false), 20.0 * kDegree) << "the range is too wide to show anything";
}

TEST(Modes, AFastSwingIsNoSaturation) {
  AttitudeFilter filter;
  ImuSimulator sim;
  sim.rate = [](double t) { return Eigen::Vector3d(8.0 * std::sin(9.0 * t), 0.0, 0.0); };
  sim.run(filter, 20.0);
  EXPECT_EQ(filter.counts().saturated, 0u);
}

TEST(Modes, MountingFaultNamesTheAxisThatPointsDown) {
  const Eigen::Quaterniond level = Eigen::Quaterniond::Identity();
  EXPECT_EQ(mounting_fault({0.0, 0.0, kGravity}, level), std::nullopt);
  EXPECT_EQ(mounting_fault({0.0, -kGravity, 0.5}, level), "gravity points along +y of the sensor: check the mounting");
  EXPECT_EQ(mounting_fault({0.0, kGravity, 0.5}, level), "gravity points along -y of the sensor: check the mounting");
  EXPECT_EQ(mounting_fault({-kGravity, 1.0, 1.0}, level), "gravity points along +x of the sensor: check the mounting");
  EXPECT_EQ(mounting_fault({1.0, 1.0, -kGravity}, level), "gravity points along +z of the sensor: check the mounting");
  // The same force is right for a sensor that is mounted so.
  const Eigen::Quaterniond on_its_side = so3::from_rpy(-0.5 * std::numbers::pi, 0.0, 0.0);
  EXPECT_EQ(mounting_fault({0.0, -kGravity, 0.0}, on_its_side), std::nullopt);
  EXPECT_NE(mounting_fault({0.0, 0.0, kGravity}, on_its_side), std::nullopt);
  // A robot on a slope of 40° is still right.
  const double slope = 40.0 * kDegree;
  EXPECT_EQ(mounting_fault({kGravity * std::sin(slope), 0.0, kGravity * std::cos(slope)}, level), std::nullopt);
}

ImuSimulator eventful() {
  ImuSimulator sim;
  sim.rate = [](double t) { return t < 3.0 || t > 15.0 ? Eigen::Vector3d(0.0, 0.0, 0.0) : waving(t); };
  sim.acceleration = [](double t) {
    return t < 3.0 ? Eigen::Vector3d(0, 0, 0) : Eigen::Vector3d(std::sin(5.0 * t), 0, 0);
  };
  sim.field = [](double t) -> Eigen::Vector3d {
    return (t > 8.0 && t < 10.0 ? 1.5 : 1.0) * Eigen::Vector3d(0.0, 20e-6, -45e-6);
  };
  sim.bias = Eigen::Vector3d(0.2, 0.3, -0.1) * kDegree;
  sim.gyro_sigma = 0.005;
  sim.force_sigma = 0.05;
  sim.field_sigma = 2e-7;
  return sim;
}

TEST(Modes, TheSameSamplesGiveTheSameBytes) {
  AttitudeFilter a;
  AttitudeFilter b;
  ImuSimulator sim_a = eventful();
  ImuSimulator sim_b = eventful();
  sim_a.run(a, 20.0);
  sim_b.run(b, 20.0);
  EXPECT_EQ(bytes_of(a), bytes_of(b));
  sim_a.run(a, 0.02);
  EXPECT_NE(bytes_of(a), bytes_of(b));
}

TEST(Modes, ALoadedFilterContinuesBitForBit) {
  // Within the levelling, at rest, disturbed, moving.
  for (const double cut : {0.3, 2.5, 9.0, 14.0}) {
    AttitudeFilter whole;
    ImuSimulator sim = eventful();
    sim.run(whole, cut);
    std::istringstream stream(bytes_of(whole));
    AttitudeFilter loaded;
    InArchive in(stream);
    in(loaded);
    EXPECT_EQ(bytes_of(loaded), bytes_of(whole));
    ImuSimulator again = sim;
    sim.run(whole, 8.0);
    again.run(loaded, 8.0);
    EXPECT_EQ(bytes_of(loaded), bytes_of(whole)) << "cut at " << cut << " s";
  }
}

TEST(Modes, ALoadedFilterRemembersHowLongARestContradictsItsBias) {
  AttitudeFilter whole;
  ImuSimulator sim;
  sim.run(whole, 10.0);
  sim.bias.z() = 1.0 * kDegree;
  sim.run(whole, 5.0);
  std::istringstream stream(bytes_of(whole));
  AttitudeFilter loaded;
  InArchive in(stream);
  in(loaded);
  ImuSimulator again = sim;
  sim.run(whole, 9.0);
  again.run(loaded, 9.0);
  EXPECT_GT(whole.gyro_bias().z(), 0.1 * kDegree);
  EXPECT_EQ(bytes_of(loaded), bytes_of(whole));
}

TEST(LowPass, SplittingAStepChangesNothing) {
  using Value = Eigen::Matrix<double, 1, 1>;
  ButterworthLowPass<Value> once(2.0);
  ButterworthLowPass<Value> often(2.0);
  FirstOrderLowPass<Value> first_once;
  FirstOrderLowPass<Value> first_often;
  const Value input(3.0);
  once.step(input, 1.5);
  first_once.step(input, 1.5, 2.0);
  for (int i = 0; i < 10; ++i) {
    often.step(input, 0.15);
    first_often.step(input, 0.15, 2.0);
  }
  EXPECT_NEAR(once.value()(0), often.value()(0), 1e-12);
  EXPECT_NEAR(once.lag()(0), often.lag()(0), 1e-12);
  EXPECT_NEAR(first_once.value()(0), first_often.value()(0), 1e-12);
  EXPECT_NEAR(first_once.value()(0), 3.0 * (1.0 - std::exp(-0.75)), 1e-12);
}

TEST(LowPass, LagIsTheIntegralOfWhatIsMissing) {
  using Value = Eigen::Matrix<double, 1, 1>;
  ButterworthLowPass<Value> filter(1.5);
  double integral = 0.0;
  constexpr double kStep = 1e-4;
  for (int i = 0; i < 50000; ++i) {
    const double before = filter.value()(0);
    const Value input(std::sin(3.0 * i * kStep) + 0.5);
    filter.step(input, kStep);
    integral += (input(0) - 0.5 * (before + filter.value()(0))) * kStep;
  }
  EXPECT_NEAR(filter.lag()(0), integral, 1e-6);
  EXPECT_GT(std::abs(integral), 0.1);
}

}  // namespace
}  // namespace waymark::imu
