// SPDX-License-Identifier: Apache-2.0
// needs plugins: dgps, odometry
// Odometry that is given as poses: the filter's pose moves by exactly the increments, whatever their intervals.
#include <gmock/gmock.h>

#include "unit/core/fusion_robot.hpp"

namespace waymark {
namespace {

const std::string kRobot = R"(
initial: { x_m: 1, y_m: 2, yaw_deg: 30 }
motion: { velocity_noise_mps_per_sqrt_s: [1.0e-3, 1.0e-3, 1.0e-3], rate_noise_radps_per_sqrt_s: [1.0e-3, 1.0e-3, 1.0e-3] }
sensors:
  - { name: wheels, plugin: odometry, model: increment, still_speed_mps: 0, still_rate_radps: 0, speed_scale_sigma: 0, curvature_sigma_per_m: 0, yaw_scale_sigma: 0 }
)";

struct Step {
  double interval_s;
  double x_m;
  double y_m;
  double yaw_rad;
};

// Turns on the spot, slips sideways, reverses, rests for long enough to count as standing; and, out of stamps that
// jitter, a step in a few microseconds between long ones.
const std::vector<Step> kSteps{{0.2, 0.1, 0.01, 0.05}, {0.21, 0.1, -0.02, -0.4},  {5e-6, 0.07, 0.0, 0.1},
                               {1.3, 0.3, 0.0, 1.2},   {0.2, 0.0, 0.0, -0.6},     {0.6, 0.0, 0.0, 0.0},
                               {0.6, 0.0, 0.0, 0.0},   {0.2, -0.15, 0.02, 0.001}, {0.05, 0.002, 0.0, 0.0},
                               {0.4, 0.4, -0.1, 3.0},  {0.2, 1e-6, 0.0, 1e-7},    {0.2, 0.1, 0.0, 0.0}};

TEST(FusionIncrement, AtStandstillTheRobotDoesNotMoveWhateverStatesItsWheelsHave) {
  for (const std::string& states : {", " + test::kNoScale, std::string()}) {
    test::FusionRobot robot(
        "initial: { x_m: 0, y_m: 0, yaw_deg: 0 }\nsensors:\n  - { name: wheels, plugin: odometry, model: increment" +
        states + " }\n");
    for (int k = 0; k < 500; ++k) {
      auto rest = std::make_shared<PoseIncrement>();
      rest->interval_s = 0.2;
      Measurement m;
      m.stamp = m.arrival = Time{from_seconds(0.2 * k)};
      m.payload = rest;
      robot.fusion().add(m);
    }
    robot.fusion().finish();
    EXPECT_LT(robot.pose_P()(0, 0), 0.01) << states;
  }
}

TEST(FusionIncrement, DeadReckoningEndsWhereTheStepsEnd) {
  test::FusionRobot robot(kRobot);
  Time now{from_seconds(100.0)};
  Pose truth = Pose::planar(1.0, 2.0, std::numbers::pi / 6.0);
  for (const Step& step : kSteps) {
    auto increment = std::make_shared<PoseIncrement>();
    increment->interval_s = step.interval_s;
    increment->x_m = step.x_m;
    increment->y_m = step.y_m;
    increment->yaw_rad = step.yaw_rad;
    Measurement m;
    m.stamp = now;
    m.arrival = now + from_seconds(step.interval_s);
    m.payload = increment;
    robot.fusion().add(m);
    now += from_seconds(step.interval_s);
    truth = truth * Pose::planar(step.x_m, step.y_m, step.yaw_rad);
    const Belief belief = robot.fusion().front(now);
    EXPECT_NEAR((belief.mean.T_map_base.p - truth.p).norm(), 0.0, 2e-5);
    EXPECT_NEAR((truth.q.conjugate() * belief.mean.T_map_base.q).vec().norm(), 0.0, 2e-5);
  }
}

TEST(FusionIncrement, ItsInnovationsAreZeroByConstructionSoTheyHaveNoNis) {
  test::FusionRobot robot(kRobot);
  for (int k = 0; k < 20; ++k) {
    auto step = std::make_shared<PoseIncrement>();
    step->interval_s = 0.2;
    step->x_m = 0.1;
    Measurement m;
    m.stamp = m.arrival = Time{from_seconds(0.2 * k)};
    m.payload = step;
    robot.fusion().add(m);
  }
  robot.fusion().finish();
  EXPECT_EQ(robot.report(0).fused, 20U);
  EXPECT_EQ(robot.report(0).nis_count, 0U);
  EXPECT_EQ(robot.report(0).nis_dof, 0U);
}

}  // namespace
}  // namespace waymark
