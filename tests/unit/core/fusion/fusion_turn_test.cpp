// SPDX-License-Identifier: Apache-2.0
// needs plugins: dgps, odometry
// A slip that turns the robot without the wheels' knowledge.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

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

TEST(FusionTurn, FixesWhoseWayIsTurnedAgainstThePredictedOneSetTheHeading) {
  for (const double turned : {1.5, -2.0, 3.1}) {
    FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels + gps());
    robot.play(turned_by(turned));
    EXPECT_THAT(robot.events(), HasSubstr("the heading was set to theirs")) << turned;
    EXPECT_NEAR(std::remainder(robot.pose().yaw() - turned, 2.0 * std::numbers::pi), 0.0, 0.1) << turned;
    EXPECT_LT(robot.report(1).gated, 20U) << turned;
  }
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
