// SPDX-License-Identifier: Apache-2.0
// needs plugins: odometry, dgps, imu, compass
// Single mistakes of a robot that drives curves, and who is named for them.
#include "waymark/host/diagnosis.hpp"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cmath>

#include "tests/unit/apps/host/diagnosis/curving_robot.hpp"

namespace waymark::host {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(Diagnosis, FindsNothingOnARobotWithoutAMistake) {
  const Examined examined = examine([](Readings&) {});
  for (const Finding& finding : examined.findings) ADD_FAILURE() << describe(finding);
}

TEST(Diagnosis, FindsNothingWrongWithAnImuOfTwoAndAHalfHertz) {
  const Examined examined = examine([](Readings&) {}, {.imu_every = 20});
  for (const Finding& finding : examined.findings) ADD_FAILURE() << describe(finding);
}

TEST(Diagnosis, NamesWheelsThatAreSwapped) {
  EXPECT_THAT(examine([](Readings& r) { std::swap(r.wheels.left_mps, r.wheels.right_mps); }).named(),
              ElementsAre("wheels"));
}

TEST(Diagnosis, FitsTheTrackWidthOfWheelsThatAreSwapped) {
  const auto swap = [](Readings& r) { std::swap(r.wheels.left_mps, r.wheels.right_mps); };
  const std::string advice = "source: swap left_mps and right_mps of wheels (or both count backwards)";
  for (const std::string track : {"0.5", "0.7"}) {
    std::string yaml = kCurvingRobot;
    yaml.replace(yaml.find("0.5"), 3, track);
    const Examined examined = examine(swap, {.yaml = yaml});
    ASSERT_THAT(examined.named(), ElementsAre("wheels"));
    const std::string& change = examined.findings.front().change;
    EXPECT_TRUE(change.starts_with(advice)) << change;
    if (track == "0.5") {
      EXPECT_EQ(change, advice);
    } else {
      EXPECT_NEAR(number_after("; sensors.wheels.track_m: ", change), 0.5, 0.03) << change;
    }
  }
}

TEST(Diagnosis, NamesWheelsThatCountTooMuchOnce) {
  const Examined examined = examine([](Readings& r) {
    r.wheels.left_mps *= 10.0;
    r.wheels.right_mps *= 10.0;
  });
  ASSERT_THAT(examined.named(), ElementsAre("wheels"));
  EXPECT_NEAR(number_after("times ", examined.findings.front().change), 0.1, 0.005);
}

TEST(Diagnosis, FitsTheTrackWidth) {
  std::string yaml = kCurvingRobot;
  yaml.replace(yaml.find("0.5"), 3, "0.7");
  const Examined examined = examine([](Readings&) {}, {.yaml = yaml});
  ASSERT_THAT(examined.named(), ElementsAre("wheels"));
  EXPECT_NEAR(number_after("sensors.wheels.track_m: ", examined.findings.front().change), 0.5, 0.03);
}

TEST(Diagnosis, NamesAGyroInDegrees) {
  EXPECT_THAT(examine([](Readings& r) { r.imu.w_sensor *= 57.29578; }).named(), ElementsAre("imu"));
}

TEST(Diagnosis, NamesAGyroThatMeasuresAnotherAxis) {
  EXPECT_THAT(examine([](Readings& r) { std::swap(r.imu.w_sensor.x(), r.imu.w_sensor.z()); }).named(),
              ElementsAre("imu"));
}

TEST(Diagnosis, FitsTheYawOfAnImu) {
  const Examined examined = examine([](Readings& r) {
    // Mounted with its x axis to the left.
    r.imu.f_sensor = {r.imu.f_sensor.y(), -r.imu.f_sensor.x(), r.imu.f_sensor.z()};
  });
  ASSERT_THAT(examined.named(), ElementsAre("imu"));
  EXPECT_NEAR(number_after("base_T_sensor.yaw_deg: ", examined.findings.front().change), 90.0, 5.0)
      << examined.findings.front().change;
}

TEST(Diagnosis, NamesAnImuWithItsHorizontalAxesSwapped) {
  const Examined examined = examine([](Readings& r) { std::swap(r.imu.f_sensor.x(), r.imu.f_sensor.y()); });
  ASSERT_THAT(examined.named(), ElementsAre("imu"));
  EXPECT_THAT(examined.findings.front().change, HasSubstr("the order or the signs of f_x_mps2 and f_y_mps2"));
}

TEST(Diagnosis, AVehicleThatLeansIntoCurvesIsNotTakenForAMirroredImu) {
  constexpr double kLean = 0.3;  // [rad] by an acceleration of 1 m/s²: thrice what takes it away from the IMU
  double before = 0.0;
  const Examined examined = examine([&](Readings& r) {
    const double left = r.speed * r.rate;
    r.imu.w_sensor.x() = -kLean * (left - before) / 0.02;
    r.imu.f_sensor.y() = (1.0 - 9.81 * kLean) * left;
    before = left;
  });
  for (const Finding& finding : examined.findings) ADD_FAILURE() << describe(finding);
}

TEST(Diagnosis, AnImuThatIsTurnedByFiveDegreesIsUsual) {
  const Examined examined = examine([](Readings& r) {
    const double turned = 5.0 * M_PI / 180.0;
    const Eigen::Vector2d f = r.imu.f_sensor.head<2>();
    r.imu.f_sensor.head<2>() = Eigen::Rotation2Dd(turned) * f;
  });
  for (const Finding& finding : examined.findings) ADD_FAILURE() << describe(finding);
}

TEST(Diagnosis, NamesAnAccelerometerInG) {
  const Examined examined = examine([](Readings& r) { r.imu.f_sensor /= 9.81; });
  ASSERT_THAT(examined.named(), ElementsAre("imu"));
  EXPECT_THAT(examined.findings.front().seen, HasSubstr("it is in g"));
}

TEST(Diagnosis, FitsTheYawOfACompass) {
  std::string yaml = kCurvingRobot;
  yaml.replace(yaml.rfind("xyz_m: [0, 0, 0]"), 16, "yaw_deg: -90");
  const Examined examined = examine([](Readings&) {}, {.yaml = yaml});
  ASSERT_THAT(examined.named(), ElementsAre("compass"));
  EXPECT_NEAR(number_after("sensors.compass.base_T_sensor.yaw_deg: ", examined.findings.front().change), 0.0, 3.0);
}

/// What a heading may be off depends on the σ that it claims.
TEST(Diagnosis, NamesACompassThatIsOffByEightDegreesIfItClaimsOne) {
  const auto off = [](Readings& r) { r.compass.heading_rad += 8.0 * M_PI / 180.0; };
  for (const Finding& finding : examine(off).findings) ADD_FAILURE() << describe(finding);
  std::string yaml = kCurvingRobot;
  yaml.replace(yaml.find("declination: none"), 17, "declination: none, sigma_deg: 1");
  EXPECT_THAT(examine(off, {.yaml = yaml}).named(), ElementsAre("compass"));
  EXPECT_THAT(examine([](Readings&) {}, {.yaml = yaml}).named(), ElementsAre());
}

TEST(Diagnosis, NamesACompassThatCountsTheOtherWay) {
  EXPECT_THAT(examine([](Readings& r) { r.compass.heading_rad *= -1.0; }).named(), ElementsAre("compass"));
}

TEST(Diagnosis, FitsTheDelayOfASensor) {
  const Examined examined = examine([](Readings&) {}, {.compass_late_s = 0.6});
  ASSERT_THAT(examined.named(), ElementsAre("compass"));
  EXPECT_NEAR(number_after("sensors.compass.delay_s: ", examined.findings.front().change), 0.6, 0.05);
}

TEST(Diagnosis, NamesAClockThatIsSecondsAhead) {
  const Examined examined = examine([](Readings&) {}, {.compass_late_s = 18.0, .chirp = 8e-4});
  ASSERT_THAT(examined.named(), ElementsAre("compass"));
  EXPECT_THAT(examined.findings.front().seen, HasSubstr("leap seconds"));
  EXPECT_EQ(number_after("sensors.compass.delay_s: ", examined.findings.front().change), 18.0);
}

TEST(Diagnosis, NamesAClockThatRunsFast) {
  const Examined examined = examine(
      [](Readings& r) {
        r.gps.speed_mps = r.speed;
        r.gps.course_rad = std::remainder(0.5 * M_PI - r.yaw, 2.0 * M_PI);
      },
      {.imu_clock_fast = 0.005});
  ASSERT_THAT(examined.named(), ElementsAre("imu"));
  EXPECT_EQ(examined.findings.front().check, "clock");
  EXPECT_NEAR(number_after("its clock is ", examined.findings.front().seen), 0.5, 0.05);
}

TEST(Diagnosis, NamesAnImuOnItsHeadInSpace) {
  std::string yaml = kCurvingRobot;
  yaml.replace(yaml.find("initial:"), 8, "motion: { kind: spatial }, initial:");
  const Examined examined = examine(
      [](Readings& r) {
        r.imu.f_sensor.z() = -9.81;
        r.imu.w_sensor.z() *= -1.0;
      },
      {.yaml = yaml});
  ASSERT_THAT(examined.named(), ElementsAre("imu"));
  EXPECT_EQ(examined.findings.front().check, "gravity");
}

TEST(Diagnosis, NamesACompassThatIsFrozen) {
  const Examined examined = examine([](Readings& r) { r.compass.heading_rad = 1.0; });
  ASSERT_THAT(examined.named(), ElementsAre("compass"));
  EXPECT_EQ(examined.findings.front().check, "frozen");
}

TEST(Diagnosis, NamesAGyroThatIsZero) {
  EXPECT_THAT(examine([](Readings& r) { r.imu.w_sensor.z() = 0.0; }).named(), ElementsAre("imu"));
}

TEST(Diagnosis, NamesAGyroThatRepeatsItsLastRate) {
  const Examined examined = examine([last = 0.0](Readings& r) mutable {
    if (r.t < 120.0) last = r.imu.w_sensor.z();
    r.imu.w_sensor.z() = last;
  });
  ASSERT_THAT(examined.named(), ElementsAre("imu"));
  EXPECT_THAT(examined.findings.front().seen, HasSubstr("its yaw rate stays the same to the last digit"));
}

TEST(Diagnosis, NamesASensorThatEndsEarly) {
  const Examined examined = examine([](Readings&) {}, {.compass_until_s = 120.0});
  ASSERT_THAT(examined.named(), ElementsAre("compass"));
  EXPECT_THAT(examined.findings.front().seen, HasSubstr("no measurement in the last 80 of 200 s of log"));
}

TEST(Diagnosis, NamesAGyroOfAnotherAxisBesideWheelsOnHills) {
  // The axis that is taken for z measures how the robot rolls, which has nothing to do with how it turns.
  const Examined examined = examine([](Readings& r) {
    r.imu.w_sensor = {0.0, r.rate, 0.05 * std::sin(2.1 * r.t) + 0.001 * r.speed};
  });
  EXPECT_THAT(examined.named(), ElementsAre("imu"));
}

TEST(Diagnosis, NamesAClockOfAnotherTimeZone) {
  const Examined examined = examine([](Readings&) {}, {.compass_late_s = 3600.0});
  ASSERT_THAT(examined.named(), ElementsAre("compass"));
  EXPECT_THAT(examined.findings.front().change, HasSubstr("{ offset_s: -3600 }"));
}

TEST(Diagnosis, NamesASensorThatDeliversNothing) {
  std::string yaml = kCurvingRobot;
  yaml.replace(yaml.rfind("] }"), 3, ", { name: second, plugin: compass, declination: none, base_T_sensor: {} }] }");
  const Examined examined = examine([](Readings&) {}, {.yaml = yaml});
  ASSERT_THAT(examined.named(), ElementsAre("second"));
  EXPECT_THAT(examined.findings.front().seen, HasSubstr("no measurement"));
}

TEST(Diagnosis, TheOddOneOutIsNotThatWhichTwoNoisyOnesContradict) {
  // A gyro that counts double, beside wheels and fixes that are too few to agree with them.
  const Examined examined = examine([](Readings& r) { r.imu.w_sensor.z() *= 2.0; });
  EXPECT_THAT(examined.named(), ElementsAre("imu"));
}

TEST(Diagnosis, SaysThatOneOfTwoIsWrongWhereNothingDecides) {
  const std::string yaml = R"({ initial: { x_m: 0, y_m: 0, yaw_deg: 0 },
    sensors: [{ name: wheels, plugin: odometry, model: differential, track_m: 0.5 },
              { name: imu, plugin: imu, base_T_sensor: { xyz_m: [0, 0, 0] } },
              { name: gps, plugin: dgps, enabled: false },
              { name: compass, plugin: compass, enabled: false }] })";
  const Examined examined = examine([](Readings& r) { r.imu.w_sensor.z() *= -1.0; }, {.yaml = yaml});
  ASSERT_EQ(examined.findings.size(), 1u);
  EXPECT_EQ(examined.findings.front().certainty, Finding::Certainty::one_of);
  EXPECT_THAT(examined.findings.front().sensors, testing::UnorderedElementsAre("wheels", "imu"));
}

TEST(Diagnosis, NamesAGyroWhoseBiasIsLargerThanItsModelAllows) {
  const Examined examined = examine([](Readings& r) { r.imu.w_sensor.z() += 0.075; });
  ASSERT_THAT(examined.named(), ElementsAre("imu"));
  EXPECT_EQ(examined.findings.front().check, "offset");
  EXPECT_NEAR(number_after("rates of imu less ", examined.findings.front().change), 0.078, 0.005);
}

TEST(Diagnosis, AnOrdinaryBiasOfAGyroIsNoMistake) {
  const Examined examined = examine([](Readings& r) { r.imu.w_sensor.z() += 0.025; });
  for (const Finding& finding : examined.findings) ADD_FAILURE() << describe(finding);
}

TEST(Diagnosis, NamesAnImuThatIsEarlyBesideWheelsAndFixes) {
  const Examined examined = examine([](Readings&) {}, {.imu_late_s = -0.4});
  EXPECT_THAT(examined.named(), ElementsAre("imu"));
}

TEST(Diagnosis, WithdrawsTurnsThatContradictedOthersOnlyEarly) {
  // A gyro that warms up: the first two evaluations see it.
  const Examined examined = examine([](Readings& r) { r.imu.w_sensor.z() *= r.t < 62.0 ? 2.0 : 1.0; });
  for (const Finding& finding : examined.findings) ADD_FAILURE() << describe(finding);
}

}  // namespace
}  // namespace waymark::host
