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
using ::testing::HasSubstr;

constexpr double kExact = 1e-12;
constexpr double kDegree = std::numbers::pi / 180.0;
const std::string kKeys = "base_p_antenna_m: [0.5, -0.2, 1.1], sigma_m: 0.3, offset_sigma_m: 0";

GnssFix moving(double speed, double course) {
  GnssFix fix;
  fix.p_map_antenna = {0.0, 0.0, 0.0};
  fix.speed_mps = speed;
  fix.course_rad = course;
  return fix;
}

/// The updates of one fix at `mean`.
struct Bench {
  explicit Bench(const std::string& more) : sensor(make_sensor("dgps", "{ " + kKeys + more + " }")) {}

  std::size_t feed(const GnssFix& fix) {
    updates.clear();
    Belief belief;
    belief.mean = mean;
    belief.P.setIdentity(layout.size(), layout.size());
    sensor->process(measurement_of(fix), {belief, layout, nullptr, nullptr, false}, updates);
    return updates.size();
  }
  Linearization model(std::size_t i) const {
    Linearization out;
    updates[i].linearize({mean, nullptr}, out);
    return out;
  }

  std::shared_ptr<Sensor> sensor;
  StateLayout layout{StateLayout::Motion::spatial, {{"gps", {}}}};
  NavState mean;
  UpdateList updates;
};

TEST(DgpsVelocity, IsNotUsedWithoutItsNoise) { EXPECT_EQ(Bench("").feed(moving(3.0, 1.0)), 1u); }

TEST(DgpsSideslip, SaysThatTheBaseDoesNotGoSideways) {
  Bench bench(", sideslip_sigma_mps: 0.05");
  bench.mean.v_base = {3.0, 0.4, 0.0};
  ASSERT_EQ(bench.feed(moving(3.0, 1.0)), 2u);
  const Linearization model = bench.model(1);
  ASSERT_EQ(model.rows(), 1);
  EXPECT_NEAR(model.residual(0), -0.4, kExact);
  EXPECT_NEAR(model.R(0, 0), 0.0025, kExact);
}

TEST(DgpsVelocity, ComesBesideThePosition) {
  Bench bench(", velocity_sigma_mps: 0.1");
  ASSERT_EQ(bench.feed(moving(3.0, 1.0)), 2u);
  EXPECT_EQ(bench.model(0).rows(), 3);
  EXPECT_EQ(bench.model(1).rows(), 2);
}

TEST(DgpsVelocity, NothingMeasuredOrTooSlowGivesNone) {
  Bench bench(", velocity_sigma_mps: 0.1, velocity_min_mps: 0.8");
  EXPECT_EQ(bench.feed(moving(GnssFix::kUnknown, 1.0)), 1u);
  EXPECT_EQ(bench.feed(moving(3.0, GnssFix::kUnknown)), 1u);
  EXPECT_EQ(bench.feed(moving(0.7, 1.0)), 1u);
  EXPECT_EQ(bench.feed(moving(0.9, 1.0)), 2u);
}

TEST(DgpsVelocity, IsThatOfTheAntennaOverGround) {
  Bench bench(", velocity_sigma_mps: 0.1");
  bench.mean.T_map_base.q = so3::from_rpy(0.0, 0.0, 0.5 * std::numbers::pi);  // forward is north, left is west
  bench.mean.v_base = {2.0, 0.0, 0.0};
  bench.mean.w_base = {0.0, 0.0, 1.0};  // adds (0.2, 0.5) in the base frame: 2.2 north, 0.5 west
  bench.feed(moving(std::hypot(2.2, 0.5), std::atan2(-0.5, 2.2)));
  EXPECT_NEAR(bench.model(1).residual.norm(), 0.0, kExact);
}

TEST(DgpsVelocity, NorthIsZeroAndEastAQuarterTurn) {
  Bench bench(", velocity_sigma_mps: 0.1");
  bench.feed(moving(3.0, 0.0));
  EXPECT_LT((bench.model(1).residual - Eigen::Vector2d(0.0, 3.0)).norm(), kExact);
  bench.feed(moving(3.0, 0.5 * std::numbers::pi));
  EXPECT_LT((bench.model(1).residual - Eigen::Vector2d(3.0, 0.0)).norm(), kExact);
}

TEST(DgpsVelocity, TheCoursesNoiseLiesAcross) {
  Bench bench(", velocity_sigma_mps: 0.1, course_sigma_deg: 3");
  bench.feed(moving(10.0, 0.0));  // north
  EXPECT_NEAR(bench.model(1).R(1, 1), 0.01, kExact);
  EXPECT_NEAR(bench.model(1).R(0, 0), 0.01 + std::pow(10.0 * 3.0 * kDegree, 2), kExact);
  EXPECT_NEAR(bench.model(1).R(0, 1), 0.0, kExact);
}

TEST(DgpsVelocity, JacobiansAgreeWithDifferences) {
  Bench bench(", velocity_sigma_mps: 0.1");
  bench.mean.T_map_base.q = so3::from_rpy(0.1, -0.2, 0.7);
  bench.mean.v_base = {2.0, -0.3, 0.1};
  bench.mean.w_base = {0.2, -0.1, 0.9};
  bench.feed(moving(2.5, 0.9));
  const Linearization model = bench.model(1);
  const NavState mean = bench.mean;
  const auto column = [&](int state) -> Eigen::Vector2d {
    if (state < 6) return model.get(Linearization::kAttitude).col(state - 3);
    if (state < 9) return model.get(Linearization::kVelocity).col(state - 6);
    return model.get(Linearization::kAngularRate).col(state - 9);
  };
  for (int state = 3; state < kCoreStates; ++state) {
    constexpr double kStep = 1e-4;
    std::array<Eigen::Vector2d, 2> moved;
    for (int side = 0; side < 2; ++side) {
      ErrorVector delta = ErrorVector::Zero(bench.layout.size());
      delta[state] = side == 0 ? kStep : -kStep;
      bench.mean = mean;
      boxplus(bench.mean, delta, bench.layout);
      moved[static_cast<std::size_t>(side)] = bench.model(1).residual;
    }
    const Eigen::Vector2d numeric = -(moved[0] - moved[1]) / (2.0 * kStep);
    EXPECT_LT((numeric - column(state)).norm(), 1e-6) << state;
  }
}

TEST(DgpsVelocity, TheCourseTellsTheStartsHeading) {
  const Bench bench(", velocity_sigma_mps: 0.1, course_sigma_deg: 2");
  const auto hint = bench.sensor->start_hint(measurement_of(moving(2.0, 60.0 * kDegree)), nullptr);
  ASSERT_TRUE(hint && hint->yaw_rad);
  EXPECT_NEAR(*hint->yaw_rad, 30.0 * kDegree, kExact);
  EXPECT_GT(hint->yaw_sigma_rad, 10.0 * kDegree);
  EXPECT_LT(hint->yaw_sigma_rad, 30.0 * kDegree);
  EXPECT_FALSE(bench.sensor->start_hint(measurement_of(moving(0.5, 1.0)), nullptr)->yaw_rad);
  const Bench reverse(", velocity_sigma_mps: 0.1, heading_from_course: false");
  EXPECT_FALSE(reverse.sensor->start_hint(measurement_of(moving(2.0, 1.0)), nullptr)->yaw_rad);
}

TEST(DgpsVelocity, RefusesItsKeysWithoutItself) {
  EXPECT_THAT(refusal("dgps", "{ " + kKeys + ", course_sigma_deg: 3 }"), HasSubstr("course_sigma_deg"));
  EXPECT_THAT(refusal("dgps", "{ " + kKeys + ", velocity_sigma_mps: 0 }"), HasSubstr("text:1:"));
}

}  // namespace
}  // namespace waymark
