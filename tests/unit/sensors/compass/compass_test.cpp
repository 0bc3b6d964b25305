// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <sstream>

#include "unit/sensors/sensor_bench.hpp"

namespace waymark {
namespace {

using sensor_test::measurement_of;
using ::testing::HasSubstr;
using Motion = StateLayout::Motion;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kExact = 1e-12;
const Eigen::Vector3d kField(0.0, 20e-6, -43e-6);  // magnetic north is true north
constexpr double kIn2025 = 1.75e9;

/// The compass in a filter that stands at `state`.
struct Bench {
  explicit Bench(const std::string& keys, Motion motion = Motion::spatial,
                 const Eigen::Quaterniond& q_base_sensor = Eigen::Quaterniond::Identity())
      : sensor(make(keys, q_base_sensor)), layout(motion, {{"compass", sensor->block()}}) {
    state.block.setZero(layout.block_size());
  }

  static std::shared_ptr<Sensor> make(const std::string& keys, const Eigen::Quaterniond& q_base_sensor) {
    const Rig rig({{"compass", "", Pose{q_base_sensor, {0.1, 0.0, 0.2}}}});
    const Config config = Config::parse("{ name: compass, " + keys + " }");
    auto sensor = PluginLoader({WAYMARK_PLUGIN_DIR}).create<Sensor>("compass", config, rig);
    config.reject_unread();
    return sensor;
  }

  template <class P>
  std::size_t feed(const P& payload, double interval = 0.1) {
    updates.clear();
    Belief belief;
    belief.mean = state;
    belief.P = 1e-4 * ErrorMatrix::Identity(layout.size(), layout.size());
    const Measurement m = measurement_of(payload, t);
    t += interval;
    sensor->process(m, {belief, layout, belief.mean.block.data(), datum ? &*datum : nullptr, false}, updates);
    return updates.size();
  }
  Linearization model() const {
    Linearization out;
    updates[0].linearize({state, state.block.data()}, out);
    return out;
  }
  double residual() const { return model().residual(0); }

  std::shared_ptr<Sensor> sensor;
  StateLayout layout;
  NavState state;
  UpdateList updates;
  std::optional<Datum> datum;
  double t = 100.0;
};

CompassHeading heading(double degrees, bool from_true_north = false) {
  CompassHeading compass;
  compass.heading_rad = degrees * kDegree;
  compass.from_true_north = from_true_north;
  return compass;
}

MagneticField field(const Eigen::Quaterniond& q_map_sensor, const Eigen::Vector3d& m_map = kField) {
  MagneticField payload;
  payload.m_sensor = q_map_sensor.conjugate() * m_map;
  return payload;
}

// --- headings ------------------------------------------------------------------------------------------------------

TEST(Compass, HeadingCountsClockwiseFromNorthAndYawFromEast) {
  Bench bench("declination: none");
  for (const auto& [shown, yaw] : {std::pair{0.0, 90.0}, {90.0, 0.0}, {180.0, -90.0}, {45.0, 45.0}}) {
    bench.state.T_map_base = Pose::planar(0.0, 0.0, yaw * kDegree);
    ASSERT_EQ(bench.feed(heading(shown)), 1u);
    EXPECT_NEAR(bench.residual(), 0.0, kExact) << shown;
  }
  bench.state.T_map_base = Pose::planar(0.0, 0.0, 40.0 * kDegree);
  bench.feed(heading(45.0));
  EXPECT_NEAR(bench.residual(), 5.0 * kDegree, kExact);
}

TEST(Compass, TheMountingIsTakenOff) {
  Bench bench("declination: none", Motion::planar, so3::from_rpy(0.0, 0.0, 0.5 * std::numbers::pi));
  bench.state.T_map_base = Pose::planar(0.0, 0.0, 0.0);  // the compass' x axis points north
  bench.feed(heading(0.0));
  EXPECT_NEAR(bench.residual(), 0.0, kExact);
}

TEST(Compass, DeclinationTurnsMagneticHeadingsOnly) {
  Bench bench("declination_deg: 3");
  bench.state.T_map_base = Pose::planar(0.0, 0.0, 87.0 * kDegree);  // 3° east of true north
  bench.feed(heading(0.0));
  EXPECT_NEAR(bench.residual(), 0.0, kExact);
  bench.feed(heading(0.0, true));
  EXPECT_NEAR(bench.residual(), 3.0 * kDegree, kExact);
}

TEST(Compass, DeclinationOfTheModelNeedsDateAndPlace) {
  Bench bench("declination: auto");
  EXPECT_THROW(bench.feed(heading(0.0)), DataError);  // no datum
  EXPECT_NO_THROW(bench.feed(heading(0.0, true)));    // none needed
  bench.datum = Datum{49.0157, 8.4258, 115.0};
  EXPECT_THROW(bench.feed(heading(0.0)), DataError);  // 1970
  bench.t = kIn2025;
  bench.state.T_map_base = Pose::planar(0.0, 0.0, (90.0 - 3.53) * kDegree);
  ASSERT_EQ(bench.feed(heading(0.0)), 1u);
  EXPECT_NEAR(bench.residual(), 0.0, 0.05 * kDegree);
}

TEST(Compass, TheReportedSigmaCountsAboveTheFloor) {
  Bench bench("declination: none, sigma_deg: 2, noise_time_s: 0");
  CompassHeading compass = heading(90.0);
  bench.feed(compass);
  EXPECT_NEAR(std::sqrt(bench.model().R(0, 0)), 2.0 * kDegree, kExact);
  compass.sigma_rad = 6.0 * kDegree;
  bench.feed(compass);
  EXPECT_NEAR(std::sqrt(bench.model().R(0, 0)), 6.0 * kDegree, kExact);
  compass.sigma_rad = 0.1 * kDegree;
  bench.feed(compass);
  EXPECT_NEAR(std::sqrt(bench.model().R(0, 0)), 2.0 * kDegree, kExact);
}

TEST(Compass, FastReadingsRepeatEachOther) {
  Bench bench("declination: none, sigma_deg: 2, noise_time_s: 3");
  bench.feed(heading(90.0), 0.1);
  EXPECT_NEAR(bench.model().R(0, 0), std::pow(2.0 * kDegree, 2), kExact);  // the first one counts in full
  bench.feed(heading(90.0), 10.0);
  EXPECT_NEAR(bench.model().R(0, 0), 60.0 * std::pow(2.0 * kDegree, 2), 1e-9);
  bench.feed(heading(90.0));
  EXPECT_NEAR(bench.model().R(0, 0), std::pow(2.0 * kDegree, 2), kExact);
}

// --- field ---------------------------------------------------------------------------------------------------------

TEST(Compass, TheFieldIsLevelledWithTheStatesRollAndPitch) {
  Bench bench("declination: none");
  const Eigen::Quaterniond q = so3::from_rpy(0.3, -0.2, 0.7);
  bench.state.T_map_base.q = q;
  ASSERT_EQ(bench.feed(field(q)), 1u);
  EXPECT_NEAR(bench.residual(), 0.0, kExact);
  bench.state.T_map_base.q = so3::exp({0.0, 0.0, -0.1}) * q;
  EXPECT_NEAR(bench.residual(), 0.1, kExact);
  bench.state.T_map_base.q = so3::from_rpy(0.0, 0.0, 0.7);  // a particle that believes it is level
  EXPECT_GT(std::abs(bench.residual()), 10.0 * kDegree);
}

TEST(Compass, AMountedMagnetometerIsTurnedIntoTheBase) {
  const Eigen::Quaterniond q_base_sensor = so3::from_rpy(0.5, 1.1, -2.0);
  Bench bench("declination_deg: 10", Motion::spatial, q_base_sensor);
  const Eigen::Quaterniond q = so3::from_rpy(0.1, -0.2, 2.7);
  bench.state.T_map_base.q = q;
  const Eigen::Vector3d m_map = so3::from_rpy(0.0, 0.0, -10.0 * kDegree) * kField;
  bench.feed(field(q * q_base_sensor, m_map));
  EXPECT_NEAR(bench.residual(), 0.0, kExact);
}

TEST(Compass, HardAndSoftIronAreTakenOff) {
  Eigen::Matrix3d soft;
  soft << 1.2, 0.1, 0.0, 0.1, 0.9, 0.05, 0.0, 0.05, 1.1;
  const Eigen::Vector3d hard(5e-6, -12e-6, 7e-6);
  Bench bench(
      "declination: none, hard_iron_t: [5e-6, -12e-6, 7e-6],"
      "soft_iron: [1.2, 0.1, 0, 0.1, 0.9, 0.05, 0, 0.05, 1.1]");
  for (int k = 0; k < 12; ++k) {
    const Eigen::Quaterniond q = so3::from_rpy(0.1, 0.2, 0.5 * k);
    bench.state.T_map_base.q = q;
    MagneticField payload = field(q);
    payload.m_sensor = soft.inverse() * payload.m_sensor + hard;
    ASSERT_EQ(bench.feed(payload), 1u);
    EXPECT_NEAR(bench.residual(), 0.0, 1e-9) << k;
  }
}

TEST(Compass, TheMagnetometerOfAnImuWillDo) {
  Bench bench("declination: none");
  const Eigen::Quaterniond q = so3::from_rpy(0.0, 0.1, 0.7);
  bench.state.T_map_base.q = q;
  ImuSample sample;
  sample.m_sensor = q.conjugate() * kField;
  ASSERT_EQ(bench.feed(sample), 1u);
  EXPECT_NEAR(bench.residual(), 0.0, kExact);
  EXPECT_THROW(bench.feed(ImuSample{}), DataError);
}

TEST(Compass, JacobiansAgreeWithDifferences) {
  Bench bench("declination_deg: 4, offset_sigma_deg: 3");
  const Eigen::Quaterniond q = so3::from_rpy(0.2, -0.3, 1.9);
  const auto check = [&] {
    const Linearization model = bench.model();
    const NavState state = bench.state;
    for (int axis = 0; axis < 4; ++axis) {
      constexpr double kStep = 1e-5;
      std::array<double, 2> moved{};
      for (int side = 0; side < 2; ++side) {
        ErrorVector delta = ErrorVector::Zero(bench.layout.size());
        delta[axis < 3 ? 3 + axis : kCoreStates] = side == 0 ? kStep : -kStep;
        bench.state = state;
        boxplus(bench.state, delta, bench.layout);
        moved[static_cast<std::size_t>(side)] = bench.residual();
      }
      bench.state = state;
      const double numeric = -(moved[0] - moved[1]) / (2.0 * kStep);
      const double analytic = axis < 3 ? model.get(Linearization::kAttitude)(0, axis) : model.get_block()(0, 0);
      EXPECT_NEAR(numeric, analytic, 1e-6) << axis;
    }
  };
  bench.state.T_map_base.q = so3::exp({0.01, 0.02, 0.05}) * q;
  ASSERT_EQ(bench.feed(field(q)), 1u);
  check();
  ASSERT_EQ(bench.feed(heading(-20.0)), 1u);
  check();
}

// --- implausible
// --------------------------------------------------------------------------------------------------------

TEST(Compass, AFieldOfWrongStrengthOrDipIsRefused) {
  Bench bench("declination: none, field_settle_s: 1");
  bench.state.T_map_base.q = so3::from_rpy(0.0, 0.0, 0.4);
  const Eigen::Quaterniond q = bench.state.T_map_base.q;
  for (int k = 0; k < 20; ++k) ASSERT_EQ(bench.feed(field(q)), 1u);
  EXPECT_EQ(bench.feed(field(q, 1.3 * kField)), 0u);
  EXPECT_THAT(std::string(bench.updates.degraded_reason()), HasSubstr("magnetic field disturbed"));
  EXPECT_EQ(bench.feed(field(q, so3::exp({-0.3, 0.0, 0.0}) * kField)), 0u);  // the dip
  int waited = 0;
  while (bench.feed(field(q)) == 0u && waited < 100) ++waited;
  EXPECT_NEAR(waited, 9, 1);  // field_settle_s
  EXPECT_TRUE(bench.updates.degraded_reason().empty());
}

TEST(Compass, WithTheModelTheFirstFieldIsJudged) {
  Bench bench("declination: auto");
  bench.datum = Datum{49.0157, 8.4258, 115.0};
  bench.t = kIn2025;
  const Eigen::Vector3d earth = 48.8e-6 * Eigen::Vector3d(0.0, std::cos(64.9 * kDegree), -std::sin(64.9 * kDegree));
  bench.state.T_map_base = Pose::planar(0.0, 0.0, -3.5 * kDegree);
  EXPECT_EQ(bench.feed(field(Eigen::Quaterniond::Identity(), 1.4 * earth)), 0u);
  std::size_t given = 0;
  for (int k = 0; k < 10; ++k) given = bench.feed(field(Eigen::Quaterniond::Identity(), earth));
  EXPECT_EQ(given, 1u);
}

TEST(Compass, AnotherFieldThatStaysWhileTheRobotTurnsIsAdopted) {
  Bench bench("declination: none, jump_sigmas: 0");
  for (int k = 0; k < 20; ++k) bench.feed(field(bench.state.T_map_base.q));
  bench.state.w_base.z() = 0.5;
  int refused = 0;
  for (int k = 0; k < 400; ++k) {
    bench.state.T_map_base.q = so3::from_rpy(0.0, 0.0, 0.05 * k);
    refused += bench.feed(field(bench.state.T_map_base.q, 1.5 * kField)) == 0u;
  }
  EXPECT_GT(refused, 90);
  EXPECT_LT(refused, 120);
}

TEST(Compass, AFieldThatMovesAlongIsNot) {
  Bench bench("declination: none, jump_sigmas: 0");
  for (int k = 0; k < 20; ++k) bench.feed(field(bench.state.T_map_base.q));
  bench.state.w_base.z() = 0.5;
  int used = 0;
  for (int k = 0; k < 400; ++k) {
    bench.state.T_map_base.q = so3::from_rpy(0.0, 0.0, 0.05 * k);
    MagneticField payload = field(bench.state.T_map_base.q);
    payload.m_sensor += Eigen::Vector3d(40e-6, 0.0, 0.0);  // a motor beside it
    used += static_cast<int>(bench.feed(payload));
  }
  EXPECT_LT(used, 120);  // where the sum happens to look like the reference
}

TEST(Compass, AHeadingThatJumpsIsDoubtedButNotForEver) {
  Bench bench("declination: none, sigma_deg: 3, jump_patience_s: 5");
  for (int k = 0; k < 10; ++k) ASSERT_EQ(bench.feed(heading(90.0 + k % 3)), 1u);
  int rejected = 0;
  for (int k = 0; k < 100; ++k) {
    if (bench.feed(heading(130.0)) > 0) continue;
    ++rejected;
    EXPECT_THAT(std::string(bench.updates.degraded_reason()), HasSubstr("heading jumps"));
  }
  EXPECT_EQ(rejected, 50);
}

// --- start, state, refusals ----------------------------------------------------------------------------------------

TEST(Compass, TellsTheStartsHeading) {
  const Bench bench("declination_deg: 2, sigma_deg: 3, offset_sigma_deg: 4", Motion::planar,
                    so3::from_rpy(0.0, 0.0, 0.3));
  const auto hint = bench.sensor->start_hint(measurement_of(heading(60.0)), nullptr);
  ASSERT_TRUE(hint && hint->yaw_rad);
  EXPECT_NEAR(*hint->yaw_rad, 28.0 * kDegree - 0.3, kExact);
  EXPECT_NEAR(hint->yaw_sigma_rad, 5.0 * kDegree, kExact);
  EXPECT_TRUE(bench.sensor->traits().is_absolute);
  EXPECT_FALSE(bench.sensor->traits().is_motion_source);
}

TEST(Compass, TheStartOfATiltedImuIsLevelledByItsForce) {
  const Eigen::Quaterniond q_base_sensor = so3::from_rpy(0.0, 0.0, 1.0);
  const Bench bench("declination: none", Motion::spatial, q_base_sensor);
  const Eigen::Quaterniond q_map_base = so3::from_rpy(0.2, -0.15, 0.7);
  ImuSample sample;
  sample.m_sensor = (q_map_base * q_base_sensor).conjugate() * kField;
  sample.f_sensor = (q_map_base * q_base_sensor).conjugate() * Eigen::Vector3d(0.0, 0.0, 9.81);
  const auto hint = bench.sensor->start_hint(measurement_of(sample), nullptr);
  ASSERT_TRUE(hint && hint->yaw_rad);
  EXPECT_NEAR(*hint->yaw_rad, so3::yaw(q_map_base), 1e-9);
}

TEST(Compass, ContinuesWhereItWasSaved) {
  Bench one("declination: none, jump_patience_s: 1");
  Bench other("declination: none, jump_patience_s: 1");
  for (int k = 0; k < 8; ++k) one.feed(heading(k < 4 ? 90.0 : 150.0));
  std::stringstream stream;
  OutArchive out(stream);
  one.sensor->save(out);
  InArchive in(stream);
  other.sensor->load(in);
  other.t = one.t;
  for (int k = 0; k < 12; ++k) EXPECT_EQ(one.feed(heading(150.0)), other.feed(heading(150.0))) << k;
  EXPECT_EQ(one.model().R(0, 0), other.model().R(0, 0));
}

TEST(Compass, WhatIsNotFiniteIsUnusable) {
  Bench bench("declination: none");
  EXPECT_THROW(bench.feed(heading(NAN)), DataError);
  MagneticField payload;
  EXPECT_THROW(bench.feed(payload), DataError);  // zero
  payload.m_sensor = {1e-5, NAN, 0.0};
  EXPECT_THROW(bench.feed(payload), DataError);
  EXPECT_THROW(bench.feed(WheelSpeeds{}), DataError);
}

std::string refusal(const std::string& keys) {
  try {
    Bench bench(keys);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "not refused";
}

TEST(Compass, RefusesWhatCannotBe) {
  EXPECT_THAT(refusal("sigma_deg: 3"), HasSubstr("declination"));
  EXPECT_THAT(refusal("declination: none, sigma_deg: 0"), HasSubstr("text:1:"));
  EXPECT_THAT(refusal("declination: none, soft_iron: [1, 0, 0, 1, 0, 0, 0, 0, 1]"), HasSubstr("singular"));
  EXPECT_THAT(refusal("declination: none, soft_iron: [1, 0, 0, 0, -1, 0, 0, 0, 1]"), HasSubstr("mirrors"));
  EXPECT_THAT(refusal("declination: none, hard_iron_t: [1, 0]"), HasSubstr("hard_iron_t"));
  const Config config = Config::parse("{ name: compass, declination: none }");
  EXPECT_THROW(PluginLoader({WAYMARK_PLUGIN_DIR})
                   .create<Sensor>("compass", config, Rig(std::vector<Mounting>{{"compass", "", {}}})),
               ConfigError);
}

}  // namespace
}  // namespace waymark
