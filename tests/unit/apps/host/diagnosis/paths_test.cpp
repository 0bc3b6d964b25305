// SPDX-License-Identifier: Apache-2.0
// needs plugins: odometry, dgps, imu, compass
// The path of a receiver's positions against dead reckoning, of robots that turn too often for directions from fix to
// fix.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <random>
#include <string>
#include <utility>

#include "tests/unit/apps/host/diagnosis/curving_robot.hpp"

namespace waymark::host {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr double kSharp = 5.0;

void expect_none(const Examined& examined) {
  for (const Finding& finding : examined.findings) ADD_FAILURE() << describe(finding);
}

/// Positions of an earlier time; before the first one it drove straight on.
class Late {
 public:
  explicit Late(double seconds) : seconds_(seconds) {}
  void operator()(Readings& r) {
    past_.emplace_back(r.t, r.gps.p_map_antenna);
    while (past_.size() > 1 && past_[1].first <= r.t - seconds_) past_.pop_front();
    const auto& [t, p] = past_.front();
    r.gps.p_map_antenna = p + std::min(0.0, r.t - seconds_ - t) * Eigen::Vector3d(0.9, 0.2, 0.0);
  }

 private:
  double seconds_;
  std::deque<std::pair<double, Eigen::Vector3d>> past_;
};

TEST(PathDiagnosis, ARobotThatTurnsOftenHasNoMistake) {
  expect_none(examine([](Readings&) {}, {.turns = kSharp}));
  expect_none(examine([](Readings&) {}, {.reverses = true}));
}

TEST(PathDiagnosis, NamesMirroredPositions) {
  const Examined swapped =
      examine([](Readings& r) { std::swap(r.gps.p_map_antenna.x(), r.gps.p_map_antenna.y()); }, {.turns = kSharp});
  ASSERT_THAT(swapped.named(), ElementsAre("gps"));
  EXPECT_EQ(swapped.findings.front().check, "mirrored");
  const Examined west = examine([](Readings& r) { r.gps.p_map_antenna.x() *= -1.0; }, {.turns = kSharp});
  EXPECT_THAT(west.named(), ElementsAre("gps"));
}

TEST(PathDiagnosis, NamesPositionsThatAreLateBySeconds) {
  const Examined late = examine(Late(2.6), {.turns = kSharp});
  ASSERT_THAT(late.named(), ElementsAre("gps"));
  EXPECT_NEAR(number_after("delay_s: ", late.findings.front().change), 2.6, 0.2) << late.findings.front().change;
  const Examined leap = examine(Late(18.0), {.chirp = 0.0004, .turns = kSharp});
  ASSERT_THAT(leap.named(), ElementsAre("gps"));
  EXPECT_THAT(leap.findings.front().seen, HasSubstr("leap seconds"));
}

/// A receiver that measures its velocity, too, which is that of an earlier time.
class Velocity {
 public:
  explicit Velocity(double late, double noise = 0.0) : course_noise_(noise), late_(late) {}
  void operator()(Readings& r) {
    past_.push_back({r.t, r.speed, std::remainder(0.5 * M_PI - r.yaw, 2.0 * M_PI)});
    while (past_.size() > 1 && past_[1].t <= r.t - late_) past_.pop_front();
    r.gps.speed_mps = past_.front().speed;
    r.gps.course_rad = past_.front().course + course_noise_ * noise_(dice_);
    r.gps.p_map_antenna += 10.0 * course_noise_ * Eigen::Vector3d(0.06, 0.06, 0.0) * noise_(dice_);
  }

 private:
  struct Past {
    double t;
    double speed;
    double course;
  };
  double course_noise_;  // [rad], as of a receiver that is carried at walking speed
  double late_;
  std::deque<Past> past_;
  std::mt19937 dice_{9};
  std::normal_distribution<double> noise_{0.0, 1.0};
};

TEST(PathDiagnosis, NamesAReceiverWithoutWheelsThatIsLateBySeconds) {
  const std::string yaml = without(kCurvingRobot, "wheels");
  expect_none(examine(Velocity(0.0), {.yaml = yaml, .turns = kSharp}));
  const Examined late = examine(Velocity(0.0, 0.7), {.yaml = yaml, .gps_late_s = 3.0, .turns = kSharp});
  EXPECT_THAT(late.named(), ElementsAre("gps"));
  ASSERT_EQ(late.findings.size(), 1U);
  EXPECT_NEAR(number_after("delay_s: ", late.findings.front().change), 3.0, 0.3) << late.findings.front().change;
}

TEST(PathDiagnosis, NamesAReceiverOrTheOnlyOtherSensor) {
  const std::string yaml = without(without(kCurvingRobot, "wheels"), "compass");
  const Examined late = examine(Velocity(0.0, 0.7), {.yaml = yaml, .gps_late_s = 3.0, .turns = kSharp});
  ASSERT_EQ(late.findings.size(), 1U);
  EXPECT_THAT(late.findings.front().sensors, testing::UnorderedElementsAre("gps", "imu"));
}

TEST(PathDiagnosis, NamesAVelocityOfAnotherTimeThanThePositions) {
  const Examined old = examine(Velocity(4.0), {.yaml = without(kCurvingRobot, "wheels"), .turns = kSharp});
  ASSERT_EQ(old.findings.size(), 1U);
  EXPECT_THAT(old.named(), ElementsAre("gps"));
  EXPECT_THAT(old.findings.front().seen, HasSubstr("its course and speed are 4"));
}

TEST(PathDiagnosis, ComparesHeadingsWithThePath) {
  const Examined turned = examine(
      [](Readings& r) { r.compass.heading_rad = std::remainder(r.compass.heading_rad + 0.5 * M_PI, 2.0 * M_PI); },
      {.turns = kSharp});
  ASSERT_THAT(turned.named(), ElementsAre("compass"));
  EXPECT_NEAR(number_after("yaw_deg: ", turned.findings.front().change), -90.0, 5.0) << turned.findings.front().change;
}

TEST(PathDiagnosis, NamesWheelsThatDriveForwardsWhereTheRobotReverses) {
  const Examined examined = examine(
      [](Readings& r) {
        r.wheels.left_mps = std::abs(r.wheels.left_mps);
        r.wheels.right_mps = std::abs(r.wheels.right_mps);
      },
      {.yaml = without(kCurvingRobot, "imu"), .reverses = true});
  ASSERT_THAT(examined.named(), ElementsAre("wheels"));
  EXPECT_THAT(examined.findings.front().seen, HasSubstr("goes backwards"));
}

}  // namespace
}  // namespace waymark::host
