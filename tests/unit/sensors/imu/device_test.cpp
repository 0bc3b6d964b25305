// SPDX-License-Identifier: Apache-2.0
// Attitudes that the device makes by itself, and the declination of the model.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "unit/sensors/sensor_bench.hpp"

namespace waymark {
namespace {

using sensor_test::measurement_of;
using ::testing::HasSubstr;
using Motion = StateLayout::Motion;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kG = 9.81;

struct Bench {
  explicit Bench(const std::string& keys, Motion motion = Motion::spatial,
                 const Eigen::Quaterniond& q_base_sensor = Eigen::Quaterniond::Identity())
      : layout(motion, {{"imu", {}}}) {
    const Rig rig({{"imu", "", Pose{q_base_sensor, {0.1, 0.0, 0.2}}}});
    const Config config = Config::parse("{ name: imu, " + keys + " }");
    sensor = PluginLoader({WAYMARK_PLUGIN_DIR}).create<Sensor>("imu", config, rig);
    config.reject_unread();
  }

  std::size_t feed(const ImuSample& sample, double interval = 0.1) {
    updates.clear();
    Belief belief;
    belief.mean = state;
    belief.P.setIdentity(layout.size(), layout.size());
    const Measurement m = measurement_of(sample, t);
    t += interval;
    sensor->process(m, {belief, layout, nullptr, datum ? &*datum : nullptr, false}, updates);
    return updates.size();
  }
  Linearization model(std::size_t i = 0) const {
    Linearization out;
    updates[i].linearize({state, nullptr}, out);
    return out;
  }

  std::shared_ptr<Sensor> sensor;
  StateLayout layout;
  NavState state;
  UpdateList updates;
  std::optional<Datum> datum;
  double t = 100.0;
};

ImuSample device(const Eigen::Quaterniond& q_enu_sensor, const Eigen::Vector3d& w = Eigen::Vector3d::Zero()) {
  ImuSample sample;
  sample.q_enu_sensor = q_enu_sensor;
  sample.w_sensor = w;
  return sample;
}

TEST(ImuDevice, ItsTiltComesBesideTheRates) {
  const Eigen::Quaterniond q_base_sensor = so3::from_rpy(0.0, 0.0, 0.5 * std::numbers::pi);
  Bench bench("yaw_bias: cascade, orientation: device, device_tilt_sigma_deg: 2, device_time_s: 0", Motion::spatial,
              q_base_sensor);
  const Eigen::Quaterniond q_map_base = so3::from_rpy(0.1, -0.05, 0.7);
  ASSERT_EQ(bench.feed(device(q_map_base * q_base_sensor, {0.3, 0.0, 0.0})), 2u);
  EXPECT_LT((bench.model(0).residual - Eigen::Vector3d(0.0, 0.3, 0.0)).norm(), 1e-9);
  bench.state.T_map_base.q = so3::exp({0.0, 0.0, 1.0}) * q_map_base;  // another heading is not an error of the tilt
  EXPECT_LT(bench.model(1).residual.norm(), 1e-12);
  EXPECT_NEAR(bench.model(1).R(0, 0), std::pow(2.0 * kDegree, 2), 1e-12);
  bench.state.T_map_base.q = so3::exp({-0.02, 0.01, 0.0}) * bench.state.T_map_base.q;
  EXPECT_NEAR(bench.model(1).residual(0), 0.02, 1e-3);
  EXPECT_NEAR(bench.model(1).residual(1), -0.01, 1e-3);
}

TEST(ImuDevice, ItsHeadingComesInsteadOfTheRates) {
  Bench bench("orientation: device, heading: true, declination_deg: 4, device_heading_sigma_deg: 6, device_time_s: 0");
  EXPECT_TRUE(bench.sensor->traits().is_absolute);
  EXPECT_FALSE(bench.sensor->traits().is_motion_source);
  const Eigen::Quaterniond q = so3::from_rpy(0.1, 0.2, 0.7);
  ASSERT_EQ(bench.feed(device(so3::from_rpy(0.0, 0.0, 4.0 * kDegree) * q)), 1u);  // it counts from magnetic north
  bench.state.T_map_base.q = so3::exp({0.01, -0.02, -0.03}) * q;
  EXPECT_LT((bench.model().residual - Eigen::Vector3d(-0.01, 0.02, 0.03)).norm(), 1e-3);
  EXPECT_NEAR(bench.model().R(2, 2), std::pow(6.0 * kDegree, 2), 1e-12);
  const auto hint = bench.sensor->start_hint(measurement_of(device(q)), nullptr);
  ASSERT_TRUE(hint && hint->yaw_rad);
  EXPECT_NEAR(*hint->yaw_rad, 0.7 - 4.0 * kDegree, 1e-12);
  EXPECT_NEAR(hint->yaw_sigma_rad, 6.0 * kDegree, 1e-12);
}

TEST(ImuDevice, FastAttitudesRepeatEachOther) {
  Bench bench("orientation: device, device_tilt_sigma_deg: 1, device_time_s: 2");
  const ImuSample sample = device(Eigen::Quaterniond::Identity());
  bench.feed(sample, 0.01);
  bench.feed(sample, 0.01);
  EXPECT_NEAR(bench.model(1).R(0, 0), 400.0 * std::pow(kDegree, 2), 1e-9);
}

TEST(ImuDevice, AnAttitudeWithoutRateWillDo) {
  Bench bench("orientation: device, heading: true");
  ImuSample sample = device(Eigen::Quaterniond::Identity());
  sample.w_sensor.setConstant(NAN);
  EXPECT_EQ(bench.feed(sample), 1u);
  EXPECT_EQ(bench.updates.motion(), UpdateList::Motion::not_reported);
  bench.t -= 0.1;
  EXPECT_THROW(bench.feed(sample), DataError);  // the same stamp again
}

TEST(ImuDevice, WithoutAttitudeASampleIsUnusable) {
  Bench bench("orientation: device");
  ImuSample sample;
  sample.w_sensor.setZero();
  EXPECT_THROW(bench.feed(sample), DataError);
  sample.q_enu_sensor.coeffs() << 0.0, 0.0, 0.0, 0.0;
  EXPECT_THROW(bench.feed(sample), DataError);
  sample.q_enu_sensor.coeffs() << 0.0, 0.0, 0.0, 0.99;  // rounded
  EXPECT_NO_THROW(bench.feed(sample));
}

TEST(ImuDevice, ItsOwnCascadeIsNotUsed) {
  Bench bench("yaw_bias: cascade, orientation: device");
  ImuSample sample = device(so3::from_rpy(0.2, 0.0, 0.0));
  sample.f_sensor = {0.0, 0.0, kG};  // says level
  for (int k = 0; k < 30; ++k) bench.feed(sample);
  ASSERT_EQ(bench.updates.size(), 2u);
  EXPECT_NEAR(bench.model(1).residual(0), std::sin(0.2), 1e-9);
}

TEST(ImuDevice, RefusesAnotherWord) {
  EXPECT_THROW(Bench("orientation: theirs"), ConfigError);
  EXPECT_THROW(Bench("device_tilt_sigma_deg: 2"), ConfigError);  // nothing reads it
}

TEST(ImuDeclination, OfTheModelByDateAndPlace) {
  const Eigen::Quaterniond q = so3::from_rpy(0.0, 0.0, 0.7);
  ImuSample sample;
  sample.w_sensor.setZero();
  sample.f_sensor = {0.0, 0.0, kG};
  sample.m_sensor = q.conjugate() * Eigen::Vector3d(0.0, 20e-6, -45e-6);
  Bench bench("heading: true, declination: auto", Motion::planar);
  bench.t = 1.75e9;  // 2025-06-15
  bench.datum = Datum{49.0157, 8.4258, 115.0};
  for (int k = 0; k < 300; ++k) bench.feed(sample, 0.01);
  ASSERT_EQ(bench.updates.size(), 1u);
  EXPECT_NEAR(bench.model().residual(0), 0.7 - 3.53 * kDegree, 0.05 * kDegree);
  const auto hint = bench.sensor->start_hint(measurement_of(sample, 1.75e9), &*bench.datum);
  ASSERT_TRUE(hint && hint->yaw_rad);
  EXPECT_NEAR(*hint->yaw_rad, 0.7 - 3.53 * kDegree, 0.05 * kDegree);
  bench.datum.reset();
  EXPECT_THROW(bench.feed(sample, 0.01), DataError);
}

TEST(ImuDeclination, DoesNotMatterWithoutHeading) {
  Bench bench("declination: auto", Motion::planar);
  EXPECT_EQ(bench.feed(device(Eigen::Quaterniond::Identity())), 1u);
}

}  // namespace
}  // namespace waymark
