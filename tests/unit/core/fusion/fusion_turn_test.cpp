// SPDX-License-Identifier: Apache-2.0
// needs plugins: dgps, odometry
// A slip that turns the robot without the wheels' knowledge.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "unit/core/fusion_robot.hpp"

namespace waymark {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using namespace test;  // NOLINT(google-build-using-namespace): the robot's parts

/// 10 s to the east, then at once in the direction `turned`, for which the wheels have no reading.
std::vector<Measurement> turned_by(double turned) {
  std::vector<Measurement> log;
  drive(log, 0.0, 30.0, 1.0);
  for (int k = 0; k < 150; ++k) {
    const double t = 0.2 * k;
    const double after = std::max(0.0, t - 10.0);
    log.push_back(fix(t, std::min(t, 10.0) + after * std::cos(turned), after * std::sin(turned)));
  }
  return in_order(log);
}

TEST(FusionTurn, TheHeadingIsFoundWithinAFewFixes) {
  for (const double turned : {1.5, -2.0, 3.1}) {
    FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels + gps());
    robot.play(turned_by(turned));
    // At 1.5 rad the fixes are within their gate of 6σ from one to the next.
    if (std::abs(turned) > 1.6) {
      EXPECT_THAT(robot.events(), HasSubstr("follows the ones before it")) << turned;
    }
    EXPECT_NEAR(std::remainder(robot.pose().yaw() - turned, 2.0 * std::numbers::pi), 0.0, 0.1) << turned;
    EXPECT_LT(robot.report(1).gated, 8U) << turned;
    for (const Seen& seen : robot.seen()) {
      if (seen.stamp < 14.0) continue;
      const double after = seen.stamp - 10.0;
      const Eigen::Vector2d true_p(10.0 + after * std::cos(turned), after * std::sin(turned));
      ASSERT_LT((seen.belief.mean.T_map_base.p.head<2>() - true_p).norm(), 0.7) << turned << " at " << seen.stamp;
    }
  }
}

TEST(FusionTurn, ARobotThatDrivesBackwardsByItsFixesTurnsAround) {
  FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels + gps());
  robot.play(turned_by(3.1));
  EXPECT_THAT(robot.events(), HasSubstr("the heading was set to theirs"));
}

TEST(FusionTurn, OneFixOfAGoodReceiverIsEnough) {
  FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels +
                    "  - { name: gps, plugin: dgps, base_p_antenna_m: none, sigma_m: 0.01, offset_sigma_m: 0 }\n");
  robot.play(turned_by(2.0));
  EXPECT_LT(robot.report(1).gated, 4U);
}

// One fix a second: a rejected one lets the robot go astray for another second.
TEST(FusionTurn, AFixThatFollowsIsUsedAtOnceHoweverFarTheTurn) {
  int degraded_without_event = 0;
  for (double turned = 0.1; turned < 1.5; turned += 0.1) {
    FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels +
                      "  - { name: gps, plugin: dgps, base_p_antenna_m: none, sigma_m: 0.02, offset_sigma_m: 0 }\n");
    std::vector<Measurement> log;
    drive(log, 0.0, 12.0, 1.0);
    for (int t = 0; t < 12; ++t) {
      const double after = std::max(0, t - 10);
      log.push_back(fix(t, std::min(t, 10) + after * std::cos(turned), after * std::sin(turned)));
    }
    robot.play(in_order(log));
    const auto seen =
        std::ranges::find_if(robot.seen(), [](const Seen& one) { return one.sensor == 1 && one.stamp > 10.5; });
    ASSERT_NE(seen, robot.seen().end());
    const Eigen::Vector2d true_p(10.0 + std::cos(turned), std::sin(turned));
    EXPECT_LT((seen->belief.mean.T_map_base.p.head<2>() - true_p).norm(), 0.1) << turned;
    const bool is_degraded = robot.fusion().health().sensors[1].state == SensorHealth::State::degraded;
    if (is_degraded && robot.events().find("follows the ones before it") == std::string::npos) ++degraded_without_event;
  }
  // Beyond the gate of all other fixes, and within 6σ.
  EXPECT_GT(degraded_without_event, 0);
}

TEST(FusionTurn, FixesThatStandElsewhereDoNot) {
  FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels + gps());
  std::vector<Measurement> log;
  drive(log, 0.0, 20.0, 1.0);
  for (int k = 0; k < 100; ++k) log.push_back(fix(0.2 * k, 0.2 * k, k < 50 ? 0.0 : 5.0));  // one jump
  robot.play(in_order(log));
  EXPECT_THAT(robot.events(), Not(HasSubstr("the heading was set to theirs")));
}

}  // namespace
}  // namespace waymark
