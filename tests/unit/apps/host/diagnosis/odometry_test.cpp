// SPDX-License-Identifier: Apache-2.0
// needs plugins: odometry, dgps, imu, compass
// Odometry that faces backwards, has lost its signs, or repeats itself.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <string>

#include "tests/unit/apps/host/diagnosis/curving_robot.hpp"

namespace waymark::host {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using testing::UnorderedElementsAre;

std::string with_model(const std::string& model) {
  std::string yaml = kCurvingRobot;
  return yaml.replace(yaml.find("model: differential, track_m: 0.5"), 33, model);
}

/// Odometry whose speed and rate are columns of their own.
void drive_by_twist(Readings& r, double sign) {
  auto twist = std::make_shared<BodyTwist>();
  twist->v_x_mps = sign * r.speed;
  twist->w_z_radps = r.rate;
  r.odometry = twist;
}

const auto kBackwards = [](Readings& r) { drive_by_twist(r, -1.0); };

TEST(OdometryDiagnosis, ASpeedBackwardsOrAnImuThatIsTurned) {
  const std::string yaml = without(with_model("model: twist"), "compass");
  EXPECT_THAT(examine([](Readings& r) { drive_by_twist(r, 1.0); }, {.yaml = yaml}).findings, IsEmpty());
  const Examined examined = examine(kBackwards, {.yaml = yaml});
  ASSERT_THAT(examined.findings, SizeIs(1));
  EXPECT_EQ(examined.findings.front().certainty, Finding::Certainty::one_of);
  EXPECT_THAT(examined.findings.front().sensors, UnorderedElementsAre("wheels", "imu"));
}

TEST(OdometryDiagnosis, AHeadingThatThePositionsConfirmDecidesForASpeedBackwards) {
  const Examined examined = examine(kBackwards, {.yaml = with_model("model: twist")});
  ASSERT_THAT(examined.findings, SizeIs(1));
  EXPECT_THAT(examined.named(), ElementsAre("wheels"));
  EXPECT_THAT(examined.findings.front().change, HasSubstr("the sign of the speed"));
}

TEST(OdometryDiagnosis, PositionsSpeakAgainstAnImuThatIsInTime) {
  std::mt19937 dice(11);
  std::normal_distribution<double> noise(0.0, 0.9);
  std::string yaml = without(with_model("model: twist"), "compass");
  yaml.replace(yaml.find("sigma_m: 0.2"), 12, "sigma_m: 1.0");
  const Examined examined = examine(
      [&](Readings& r) {
        drive_by_twist(r, 1.0);
        r.gps.p_map_antenna += Eigen::Vector3d(noise(dice), noise(dice), 0.0);
      },
      {.yaml = yaml, .wheels_late_s = -1.0});
  ASSERT_THAT(examined.findings, SizeIs(1));
  EXPECT_THAT(examined.findings.front().sensors, testing::Contains("wheels"));
}

/// Turns on the spot, forwards and backwards, one after the other.
void drive_without_signs(Readings& r, bool has_signs) {
  const double phase = std::fmod(r.t, 18.0);
  const double way = phase < 6.0 ? 1.0 : phase < 12.0 ? 0.0 : -1.0;
  r.wheels.left_mps = 0.4 * way - 0.25 * r.rate;
  r.wheels.right_mps = 0.4 * way + 0.25 * r.rate;
  if (has_signs) return;
  r.wheels.left_mps = std::abs(r.wheels.left_mps);
  r.wheels.right_mps = std::abs(r.wheels.right_mps);
}

TEST(OdometryDiagnosis, NamesWheelsThatHaveLostTheirSigns) {
  const std::string yaml = without(without(kCurvingRobot, "gps"), "compass");
  const auto level = [](Readings& r) { r.imu.f_sensor = {0.0, 0.0, 9.81}; };
  const auto with = [&](bool has_signs) {
    return examine(
        [&](Readings& r) {
          level(r);
          drive_without_signs(r, has_signs);
        },
        {.yaml = yaml});
  };
  EXPECT_THAT(with(true).findings, IsEmpty());
  const Examined examined = with(false);
  EXPECT_THAT(examined.named(), ElementsAre("wheels"));
  ASSERT_THAT(examined.findings, SizeIs(1));
  EXPECT_THAT(examined.findings.front().seen, HasSubstr("never run backwards"));
}

TEST(OdometryDiagnosis, NamesASteeringAngleThatFreezes) {
  const auto steer = [](double frozen_from) {
    return [frozen_from, last = 0.0](Readings& r) mutable {
      if (r.t < frozen_from) last = std::atan2(r.rate, r.speed);
      auto steering = std::make_shared<WheelSteering>();
      steering->speed_mps = r.speed;
      steering->steering_rad = last;
      r.odometry = steering;
    };
  };
  const std::string yaml = with_model("model: ackermann, wheelbase_m: 1.0");
  EXPECT_THAT(examine(steer(kLength), {.yaml = yaml}).findings, IsEmpty());
  const Examined examined = examine(steer(0.6 * kLength), {.yaml = yaml});
  EXPECT_THAT(examined.named(), ElementsAre("wheels"));
  ASSERT_FALSE(examined.findings.empty());
  EXPECT_EQ(examined.findings.front().check, "frozen");
}

}  // namespace
}  // namespace waymark::host
