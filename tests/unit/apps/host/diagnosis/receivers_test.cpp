// SPDX-License-Identifier: Apache-2.0
// needs plugins: odometry, dgps, imu, compass
// Single mistakes of a satellite receiver on a robot that drives curves.
#include <gmock/gmock.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "tests/unit/apps/host/diagnosis/curving_robot.hpp"

namespace waymark::host {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(ReceiverDiagnosis, NamesSwappedEastAndNorth) {
  EXPECT_THAT(examine([](Readings& r) { std::swap(r.gps.p_map_antenna.x(), r.gps.p_map_antenna.y()); }).named(),
              ElementsAre("gps"));
}

TEST(ReceiverDiagnosis, NamesSwappedLatitudeAndLongitudeBesideWheelsAlone) {
  std::string yaml = kCurvingRobot;
  for (const char* name : {"imu", "compass"})
    yaml.replace(yaml.find(std::string("name: ") + name), 6, "enabled: false, name: ");
  const Examined examined = examine(
      [](Readings& r) {
        constexpr double kDegreesPerMetre = 180.0 / M_PI / 6'371'000.0;
        const Eigen::Vector3d p = r.gps.p_map_antenna;
        r.gps.longitude_deg = 49.0 + kDegreesPerMetre * p.y();
        r.gps.latitude_deg = 8.4 + kDegreesPerMetre * p.x() / std::cos(49.0 * M_PI / 180.0);
        r.gps.p_map_antenna.setConstant(std::nan(""));
      },
      {.yaml = yaml});
  ASSERT_THAT(examined.named(), ElementsAre("gps"));
  EXPECT_EQ(examined.findings.front().change, "source: swap latitude_deg and longitude_deg of gps");
}

TEST(ReceiverDiagnosis, AnAntennaAheadOfTheBaseTurnsEarlierWithoutADelay) {
  constexpr double kAhead = 0.9;
  std::string yaml = kCurvingRobot;
  yaml.replace(yaml.find("base_p_antenna_m: none"), 22, "base_p_antenna_m: [0.9, 0, 0]");
  std::mt19937 dice(3);
  std::normal_distribution<double> noise(0.0, 0.02);
  const Examined examined = examine(
      [&](Readings& r) {
        r.gps.p_map_antenna += kAhead * Eigen::Vector3d(std::cos(r.yaw), std::sin(r.yaw), 0.0);
        r.gps.speed_mps = std::hypot(r.speed, kAhead * r.rate);
        const double direction = r.yaw + std::atan2(kAhead * r.rate, r.speed) + noise(dice);
        r.gps.course_rad = std::remainder(0.5 * M_PI - direction, 2.0 * M_PI);
      },
      {.yaml = yaml});
  for (const Finding& finding : examined.findings) ADD_FAILURE() << describe(finding);
}

TEST(ReceiverDiagnosis, FitsAnAntennaBesideAGyroWithABias) {
  constexpr double kLeft = 0.8;
  std::string yaml = kCurvingRobot;
  yaml.replace(yaml.find("base_p_antenna_m: none"), 22, "base_p_antenna_m: [0, -0.8, 0]");
  const Examined examined = examine(
      [&](Readings& r) {
        r.gps.p_map_antenna += kLeft * Eigen::Vector3d(-std::sin(r.yaw), std::cos(r.yaw), 0.0);
        r.imu.w_sensor.z() += 0.02;
      },
      {.yaml = yaml});
  ASSERT_THAT(examined.named(), ElementsAre("gps"));
  EXPECT_EQ(examined.findings.front().check, "lever arm");
  EXPECT_NEAR(number_after(", ", examined.findings.front().change), kLeft, 0.15) << examined.findings.front().change;
}

TEST(ReceiverDiagnosis, NamesOneWhoseCourseIsNotTheDirectionOfItsPath) {
  const Examined examined = examine([](Readings& r) {
    r.gps.speed_mps = r.speed;
    r.gps.course_rad = std::remainder(0.5 * M_PI - r.yaw + 1.5, 2.0 * M_PI);
  });
  ASSERT_THAT(examined.named(), ElementsAre("gps"));
  EXPECT_EQ(examined.findings.front().check, "course");
}

TEST(ReceiverDiagnosis, NamesOneThatRepeatsItsLastFix) {
  Eigen::Vector3d last = Eigen::Vector3d::Zero();
  const Examined examined = examine([&](Readings& r) {
    if (r.t < 120.0) last = r.gps.p_map_antenna;
    r.gps.p_map_antenna = last;
  });
  ASSERT_THAT(examined.named(), testing::Contains("gps"));
  EXPECT_EQ(examined.findings.front().check, "frozen");
}

/// Of what a receiver delivers, the position of `late_s` before.
class Lagging {
 public:
  explicit Lagging(double late_s) : steps_(static_cast<std::size_t>(late_s / 0.02)) {}
  void delay(Readings& readings) {
    past_.push_back(readings.gps.p_map_antenna);
    readings.gps.p_map_antenna = past_[past_.size() > steps_ ? past_.size() - 1 - steps_ : 0];
  }

 private:
  std::size_t steps_;
  std::vector<Eigen::Vector3d> past_;
};

std::string with_sigma(const std::string& sigma_m) {
  std::string yaml = kCurvingRobot;
  return yaml.replace(yaml.find("sigma_m: 0.2"), 12, "sigma_m: " + sigma_m);
}

TEST(ReceiverDiagnosis, NamesOneOfAnotherClassThanDeclared) {
  std::mt19937 dice(5);
  std::normal_distribution<double> noise(0.0, 0.3);
  const auto usual = [&](Readings& r) { r.gps.p_map_antenna += Eigen::Vector3d(noise(dice), noise(dice), 0.0); };
  const Examined examined = examine(usual, {.yaml = with_sigma("0.01")});
  ASSERT_THAT(examined.named(), ElementsAre("gps"));
  EXPECT_EQ(examined.findings.front().check, "noise");
  EXPECT_NEAR(number_after("sensors.gps.sigma_m: ", examined.findings.front().change), 0.32, 0.05);
  for (const Finding& finding : examine(usual, {.yaml = with_sigma("0.3")}).findings)
    ADD_FAILURE() << describe(finding);
}

TEST(ReceiverDiagnosis, NamesOneWhoseVelocityIsOlderThanItsPositions) {
  std::vector<Readings> past;
  const Examined examined = examine(
      [&](Readings& r) {
        past.push_back(r);
        const Readings& before = past[past.size() > 50 ? past.size() - 51 : 0];
        r.gps.speed_mps = before.speed;
        r.gps.course_rad = std::remainder(0.5 * M_PI - before.yaw, 2.0 * M_PI);
      },
      {.yaml = with_sigma("0.02")});
  ASSERT_THAT(examined.named(), ElementsAre("gps"));
  EXPECT_NEAR(number_after("its course and speed are ", examined.findings.front().seen), 1.0, 0.2);
}

TEST(ReceiverDiagnosis, NoisyFixesAreNoMeasureOfCurvesThatAreTighter) {
  std::mt19937 dice(5);
  std::normal_distribution<double> noise(0.0, 0.5);
  const Examined examined =
      examine([&](Readings& r) { r.gps.p_map_antenna += Eigen::Vector3d(noise(dice), noise(dice), 0.0); },
              {.yaml = with_sigma("0.6"), .turns = 2.5});
  for (const Finding& finding : examined.findings) ADD_FAILURE() << describe(finding);
}

TEST(ReceiverDiagnosis, AQuarterOfASecondMattersOnlyWherePositionsAreExact) {
  Lagging exact(0.26);
  const Examined late = examine([&](Readings& r) { exact.delay(r); }, {.yaml = with_sigma("0.02")});
  ASSERT_THAT(late.named(), ElementsAre("gps"));
  EXPECT_NEAR(number_after("sensors.gps.delay_s: ", late.findings.front().change), 0.26, 0.05);
  Lagging usual(0.26);
  const Examined unexact = examine([&](Readings& r) { usual.delay(r); }, {.yaml = with_sigma("1.5")});
  for (const Finding& finding : unexact.findings) ADD_FAILURE() << describe(finding);
}

TEST(ReceiverDiagnosis, FortyCentimetresOfAnAntennaMatterOnlyWherePositionsAreExact) {
  const auto beside = [](Readings& r) {
    r.gps.p_map_antenna += 0.4 * Eigen::Vector3d(-std::sin(r.yaw), std::cos(r.yaw), 0.0);
  };
  const auto placed = [](std::string yaml) {
    return yaml.replace(yaml.find("base_p_antenna_m: none"), 22, "base_p_antenna_m: [0, 0, 0]");
  };
  const Examined exact = examine(beside, {.yaml = placed(with_sigma("0.02"))});
  ASSERT_THAT(exact.named(), ElementsAre("gps"));
  EXPECT_EQ(exact.findings.front().check, "lever arm");
  const Examined unexact = examine(beside, {.yaml = placed(with_sigma("1.5"))});
  for (const Finding& finding : unexact.findings) ADD_FAILURE() << describe(finding);
}

TEST(ReceiverDiagnosis, NamesOneThatRepeatsItsLastFixBesideALivingVelocity) {
  Eigen::Vector3d last = Eigen::Vector3d::Zero();
  const Examined examined = examine([&](Readings& r) {
    r.gps.speed_mps = r.speed;
    r.gps.course_rad = std::remainder(0.5 * M_PI - r.yaw, 2.0 * M_PI);
    if (r.t < 120.0) last = r.gps.p_map_antenna;
    r.gps.p_map_antenna = last;
    r.wheels.left_mps = r.wheels.right_mps = 0.0;
  });
  EXPECT_THAT(examined.findings,
              testing::Contains(testing::Field(&Finding::seen, HasSubstr("in which its velocity sums up to"))));
}

TEST(ReceiverDiagnosis, TheNoiseOfItsSpeedIsNoMotionOfARobotThatStands) {
  std::mt19937 dice(3);
  std::normal_distribution<double> noise(0.0, 0.06);
  const Examined examined = examine(
      [&](Readings& r) {
        r.gps.speed_mps = std::hypot(r.speed + noise(dice), noise(dice));
        r.gps.course_rad = std::remainder(0.5 * M_PI - r.yaw, 2.0 * M_PI);
      },
      {.stands_until_s = kLength});
  for (const Finding& finding : examined.findings) ADD_FAILURE() << describe(finding);
}

TEST(ReceiverDiagnosis, NamesOneWhosePositionsAreInFeet) {
  const Examined examined = examine([](Readings& r) { r.gps.p_map_antenna /= 0.3048; });
  ASSERT_THAT(examined.named(), ElementsAre("gps"));
  EXPECT_EQ(examined.findings.front().change, "source: positions of gps times 0.3048 (feet)");
}

TEST(ReceiverDiagnosis, NamesOneWhosePositionsWereRounded) {
  constexpr double kDegreesPerMetre = 1.0 / 111e3;
  const auto rounded = [&](double decimals, const std::string& sigma_m) {
    const double scale = std::pow(10.0, decimals);
    return examine(
        [&](Readings& r) {
          const Eigen::Vector3d p = r.gps.p_map_antenna;
          r.gps.latitude_deg = std::round((49.0 + kDegreesPerMetre * p.y()) * scale) / scale;
          r.gps.longitude_deg =
              std::round((8.4 + kDegreesPerMetre * p.x() / std::cos(49.0 * M_PI / 180.0)) * scale) / scale;
          r.gps.height_m = 0.0;
          r.gps.p_map_antenna.setConstant(std::nan(""));
        },
        {.yaml = with_sigma(sigma_m)});
  };
  const Examined four = rounded(4.0, "1");
  ASSERT_THAT(four.named(), testing::Contains("gps"));
  EXPECT_THAT(four.named(), testing::Each("gps"));
  EXPECT_THAT(four.findings.front().seen, HasSubstr("latitude and longitude have 4 decimals"));
  const Examined seven = rounded(7.0, "0.2");
  for (const Finding& finding : seven.findings) ADD_FAILURE() << describe(finding);
}

TEST(ReceiverDiagnosis, ARobotThatRestsNearARoundLatitudeHasAllDecimals) {
  const Examined examined = examine(
      [](Readings& r) {
        r.gps.latitude_deg = -33.9 + 1e-6 * r.gps.p_map_antenna.y();
        r.gps.longitude_deg = 151.2 + 1e-6 * r.gps.p_map_antenna.x();
        r.gps.height_m = 0.0;
        r.gps.p_map_antenna.setConstant(std::nan(""));
      },
      {.stands_until_s = kLength});
  for (const Finding& finding : examined.findings) ADD_FAILURE() << describe(finding);
}

/// A boat in a current, or a drone: its path has nothing to do with where it looks.
TEST(ReceiverDiagnosis, ThePathOfWhatMovesSidewaysContradictsNobody) {
  std::string yaml = kCurvingRobot;
  yaml.replace(yaml.find("name: wheels"), 6, "enabled: false, name: ");
  double direction = 0.0;
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  const Examined examined = examine(
      [&](Readings& r) {
        direction += 0.02 * (0.25 * std::sin(0.11 * r.t + 1.0) + 0.2 * std::cos(0.47 * r.t));
        p += 0.02 * 2.0 * Eigen::Vector3d(std::cos(direction), std::sin(direction), 0.0);
        r.gps.p_map_antenna = p;
        r.gps.speed_mps = 2.0;
        r.gps.course_rad = std::remainder(0.5 * M_PI - direction, 2.0 * M_PI);
      },
      {.yaml = yaml});
  for (const Finding& finding : examined.findings) ADD_FAILURE() << describe(finding);
}

}  // namespace
}  // namespace waymark::host
