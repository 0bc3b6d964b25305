// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "unit/sensors/sensor_bench.hpp"

namespace waymark {
namespace {

using sensor_test::measurement_of;
using ::testing::HasSubstr;
using Motion = StateLayout::Motion;

constexpr double kG = 9.81;

/// The sensor behind a filter that stands at `state`; one list of updates per sample.
struct Bench {
  explicit Bench(const std::string& keys = "", Motion motion = Motion::spatial,
                 const Eigen::Quaterniond& q_base_sensor = Eigen::Quaterniond::Identity())
      : layout(motion, {{"imu", {}}}) {
    const Rig rig({{"imu", "", Pose{q_base_sensor, {0.1, 0.0, 0.2}}}});
    const Config config = Config::parse("{ name: imu" + keys + " }");
    sensor = PluginLoader({WAYMARK_PLUGIN_DIR}).create<Sensor>("imu", config, rig);
    config.reject_unread();
  }

  /// Feeds the sample for `seconds` at 100 Hz; the last updates stay in `updates`.
  void feed(const ImuSample& sample, double seconds) {
    for (int i = 0; i < static_cast<int>(std::lround(seconds * 100.0)); ++i) {
      updates.clear();
      Belief belief;
      belief.mean = state;
      belief.P = variance * ErrorMatrix::Identity(layout.size(), layout.size());
      const Measurement m = measurement_of(sample, t);
      t += 0.01;
      sensor->process(m, {belief, layout, &yaw_bias, nullptr, false}, updates);
    }
  }
  Linearization model(std::size_t i) const {
    Linearization out;
    updates[i].linearize({state, &yaw_bias}, out);
    return out;
  }

  std::shared_ptr<Sensor> sensor;
  StateLayout layout;
  NavState state;
  UpdateList updates;
  double yaw_bias = 0.0;  // the sensor's own state
  double variance = 1.0;  // of every state
  double t = 100.0;
};

ImuSample sample_of(const Eigen::Vector3d& w, const Eigen::Quaterniond& q_map_sensor, bool field = true) {
  ImuSample sample;
  sample.w_sensor = w;
  sample.f_sensor = q_map_sensor.conjugate() * Eigen::Vector3d(0.0, 0.0, kG);
  if (field) sample.m_sensor = q_map_sensor.conjugate() * Eigen::Vector3d(0.0, 20e-6, -45e-6);
  return sample;
}

TEST(Imu, GivesTheRateInTheBaseFrameAndTheTilt) {
  const Eigen::Quaterniond q_base_sensor = so3::from_rpy(0.0, 0.0, 0.5 * M_PI);
  Bench bench("", Motion::spatial, q_base_sensor);
  const Eigen::Quaterniond q_map_base = so3::from_rpy(0.1, -0.05, 0.7);
  bench.feed(sample_of(Eigen::Vector3d::Zero(), q_map_base * q_base_sensor), 3.0);
  bench.feed(sample_of({0.3, 0.0, 0.0}, q_map_base * q_base_sensor), 0.01);
  ASSERT_EQ(bench.updates.size(), 2u);
  const Linearization rate = bench.model(0);
  ASSERT_EQ(rate.rows(), 3);
  EXPECT_LT((rate.residual - Eigen::Vector3d(0.0, 0.3, 0.0)).norm(), 1e-3);

  bench.state.T_map_base.q = so3::exp({0.0, 0.0, 2.0}) * q_map_base;  // another heading is not an error of the tilt
  EXPECT_LT(bench.model(1).residual.norm(), 3e-3);
  bench.state.T_map_base.q = so3::exp({-0.02, 0.01, 0.0}) * bench.state.T_map_base.q;
  const Linearization tilt = bench.model(1);
  ASSERT_EQ(tilt.rows(), 2);
  EXPECT_NEAR(tilt.residual(0), 0.02, 2e-3);
  EXPECT_NEAR(tilt.residual(1), -0.01, 2e-3);
}

TEST(Imu, InThePlaneGivesOneRate) {
  Bench bench("", Motion::planar);
  bench.feed(sample_of({0.0, 0.0, 0.4}, Eigen::Quaterniond::Identity(), false), 0.5);
  ASSERT_EQ(bench.updates.size(), 1u);
  EXPECT_EQ(bench.model(0).rows(), 1);
  EXPECT_NEAR(bench.model(0).residual(0), 0.4, 1e-3);
}

TEST(Imu, RateNoiseIsADensityAndFallsWhenTheBiasIsKnown) {
  Bench bench(", yaw_bias: cascade", Motion::planar);
  const ImuSample rest = sample_of(Eigen::Vector3d::Zero(), Eigen::Quaterniond::Identity(), false);
  bench.feed(rest, 0.5);
  const double before = bench.model(0).R(0, 0);
  bench.feed(rest, 5.0);
  const double at_100_hz = bench.model(0).R(0, 0);
  EXPECT_LT(at_100_hz, 0.1 * before);
  bench.t += 0.01;
  bench.feed(rest, 0.01);
  EXPECT_NEAR(bench.model(0).R(0, 0), 0.5 * at_100_hz, 0.1 * at_100_hz) << "after twice the time";
}

TEST(Imu, TheYawBiasIsAStateAndNoNoise) {
  for (const Motion motion : {Motion::planar, Motion::spatial}) {
    Bench bench("", motion);
    const StateBlock block = bench.sensor->block();
    ASSERT_EQ(block.size(), 1u);
    EXPECT_GT(block[0].initial_sigma, 0.0);
    EXPECT_GT(block[0].walk_per_sqrt_s, 0.0);
    // At rest the cascade learns the bias of 0.02 rad/s; the main filter gets the rate with it, to learn it by itself.
    ImuSample rest = sample_of({0.0, 0.0, 0.02}, Eigen::Quaterniond::Identity(), false);
    bench.feed(rest, 5.0);
    const Eigen::Index z = motion == Motion::planar ? 0 : 2;
    EXPECT_NEAR(bench.model(0).residual(z), 0.02, 1e-4);
    EXPECT_EQ(bench.model(0).get_block()(z, 0), 1.0);
    bench.yaw_bias = 0.02;
    EXPECT_NEAR(bench.model(0).residual(z), 0.0, 1e-4);
    const double noise = bench.model(0).R(z, z);
    bench.feed(rest, 5.0);
    EXPECT_NEAR(bench.model(0).R(z, z), noise, 1e-3 * noise) << "what is known of the bias is not in the noise";
  }
  EXPECT_TRUE(Bench(", heading: true, declination_deg: 0").sensor->block().empty());
  EXPECT_TRUE(Bench(", yaw_bias: cascade").sensor->block().empty());
}

TEST(Imu, ASmoothDriveInACurveDoesNotTeachTheYawBias) {
  // Not a tremor: what an IMU feels at rest, and on a good road.
  const ImuSample curve = sample_of({0.0, 0.0, 0.03}, Eigen::Quaterniond::Identity(), false);
  const ImuSample straight = sample_of({0.0, 0.0, 0.003}, Eigen::Quaterniond::Identity(), false);
  Bench unknown("", Motion::planar);
  unknown.feed(curve, 15.0);
  EXPECT_EQ(unknown.updates.size(), 2u) << "the speed is not known: it may be rest";
  for (const auto& [sample, updates] : {std::pair(curve, 1u), std::pair(straight, 2u)}) {
    Bench bench("", Motion::planar);
    bench.state.v_base = {1.0, 0.0, 0.0};
    bench.variance = 0.01;
    bench.feed(sample, 15.0);
    EXPECT_EQ(bench.updates.size(), updates);
  }
}

TEST(Imu, TellsRest) {
  Bench bench;
  bench.feed(sample_of(Eigen::Vector3d::Zero(), Eigen::Quaterniond::Identity()), 3.0);
  EXPECT_EQ(bench.updates.motion(), UpdateList::Motion::still);
  bench.feed(sample_of({0.0, 0.0, 0.3}, Eigen::Quaterniond::Identity()), 0.01);
  EXPECT_EQ(bench.updates.motion(), UpdateList::Motion::moving);
  Bench silent(", reports_standstill: false");
  silent.feed(sample_of(Eigen::Vector3d::Zero(), Eigen::Quaterniond::Identity()), 3.0);
  EXPECT_EQ(silent.updates.motion(), UpdateList::Motion::not_reported);
}

TEST(Imu, HeadingComesInsteadOfTheRates) {
  const Eigen::Quaterniond q = so3::from_rpy(0.1, 0.2, 0.7);
  Bench bench(", heading: true");
  EXPECT_FALSE(bench.sensor->traits().is_motion_source);
  EXPECT_TRUE(bench.sensor->traits().is_absolute);
  bench.feed(sample_of(Eigen::Vector3d::Zero(), q), 3.0);
  ASSERT_EQ(bench.updates.size(), 1u);
  bench.state.T_map_base.q = so3::exp({0.01, -0.02, -0.03}) * q;
  EXPECT_LT((bench.model(0).residual - Eigen::Vector3d(-0.01, 0.02, 0.03)).norm(), 1e-3);

  Bench planar(", heading: true, declination_deg: 10", Motion::planar);
  planar.feed(sample_of(Eigen::Vector3d::Zero(), so3::from_rpy(0.0, 0.0, 0.7)), 3.0);
  ASSERT_EQ(planar.updates.size(), 1u);
  EXPECT_NEAR(planar.model(0).residual(0), 0.7 - 10.0 * M_PI / 180.0, 1e-3);
  const auto hint = planar.sensor->start_hint(
      measurement_of(sample_of(Eigen::Vector3d::Zero(), so3::from_rpy(0.0, 0.0, 0.7))), nullptr);
  ASSERT_TRUE(hint && hint->yaw_rad);
  EXPECT_NEAR(*hint->yaw_rad, 0.7 - 10.0 * M_PI / 180.0, 1e-9);
}

TEST(Imu, HeadingAndRatesTogetherAreBoth) {
  const Eigen::Quaterniond q = so3::from_rpy(0.1, 0.2, 0.7);
  Bench bench(", heading: true, rates: true");
  EXPECT_TRUE(bench.sensor->traits().is_motion_source);
  EXPECT_TRUE(bench.sensor->traits().is_absolute);
  EXPECT_TRUE(bench.sensor->block().empty());
  bench.feed(sample_of(Eigen::Vector3d::Zero(), q), 3.0);
  ASSERT_EQ(bench.updates.size(), 2u);
  bench.state.w_base = Eigen::Vector3d(0.1, 0.2, 0.3);
  EXPECT_LT((bench.model(0).residual - Eigen::Vector3d(-0.1, -0.2, -0.3)).norm(), 1e-3);
  bench.state.T_map_base.q = so3::exp({0.01, -0.02, -0.03}) * q;
  EXPECT_LT((bench.model(1).residual - Eigen::Vector3d(-0.01, 0.02, 0.03)).norm(), 1e-3);
  EXPECT_FALSE(Bench(", heading: true, rates: false").sensor->traits().is_motion_source);
  EXPECT_THROW(Bench(", rates: true"), ConfigError) << "without heading the rates are always given";
}

TEST(Imu, WithTheRatesTheFirstSampleAlreadyGivesTheAttitude) {
  const Eigen::Quaterniond q = so3::from_rpy(0.3, -0.2, 0.7);
  Bench bench(", heading: true, rates: true");
  bench.feed(sample_of(Eigen::Vector3d::Zero(), q), 0.01);
  ASSERT_EQ(bench.updates.size(), 2u);
  bench.state.T_map_base.q = q;
  EXPECT_LT(bench.model(1).residual.norm(), 1e-9);
  bench.feed(sample_of(Eigen::Vector3d::Zero(), q), 0.01);
  EXPECT_EQ(bench.updates.size(), 1u) << "the next one comes after the levelling";
}

TEST(Imu, OneAttitudeCountsInFullWhileTheMainFilterIsMuchLessCertain) {
  const auto variance_with = [](const std::string& keys, double main) {
    Bench bench(keys);
    bench.variance = main;
    bench.feed(sample_of(Eigen::Vector3d::Zero(), Eigen::Quaterniond::Identity()), 3.0);
    return bench.model(bench.updates.size() - 1).R(0, 0);
  };
  const std::string both = ", heading: true, rates: true";
  EXPECT_NEAR(variance_with(both, 1e-9) / variance_with(both, 1.0), 2.0 * 2.0 / 0.01, 1e-6);  // 2 · time / interval
  EXPECT_EQ(variance_with(", heading: true", 1.0), variance_with(both, 1e-9));
}

TEST(Imu, AWrongMountingIsRefusedWithTheAxis) {
  Bench bench;
  const Eigen::Quaterniond on_its_side = so3::from_rpy(-0.5 * M_PI, 0.0, 0.0);
  try {
    bench.feed(sample_of(Eigen::Vector3d::Zero(), on_its_side), 2.0);
    FAIL() << "not refused";
  } catch (const DataError& error) {
    EXPECT_THAT(error.what(), HasSubstr("gravity points along +y of the sensor: check the mounting"));
  }
  EXPECT_THROW(bench.feed(sample_of(Eigen::Vector3d::Zero(), on_its_side), 0.01), DataError);
  Bench right("", Motion::spatial, on_its_side);
  right.feed(sample_of(Eigen::Vector3d::Zero(), on_its_side), 2.0);
  EXPECT_EQ(right.updates.size(), 3u);  // rate, its bias at rest, tilt
}

TEST(Imu, ASampleWithoutRateIsUnusable) {
  Bench bench;
  EXPECT_THROW(bench.feed(ImuSample{}, 0.01), DataError);
}

TEST(Imu, NeedsItsMounting) {
  const Config config = Config::parse("{ name: imu }");
  EXPECT_THROW(
      PluginLoader({WAYMARK_PLUGIN_DIR}).create<Sensor>("imu", config, Rig(std::vector<Mounting>{{"imu", "", {}}})),
      ConfigError);
  EXPECT_THROW(Bench(", heading: true, tilt: false"), ConfigError);
}

}  // namespace
}  // namespace waymark
