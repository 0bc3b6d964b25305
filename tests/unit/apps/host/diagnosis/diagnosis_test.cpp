// SPDX-License-Identifier: Apache-2.0
// needs plugins: odometry, dgps, imu, compass
// Single mistakes of a robot that drives curves, and who is named for them.
#include "waymark/host/diagnosis.hpp"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <random>

#include "tests/unit/apps/host/diagnosis/measurement_feed.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::host {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr double kLength = 200.0;  // [s]
constexpr const char* kYaml = R"({ initial: { x_m: 0, y_m: 0, yaw_deg: 0 },
  sensors: [{ name: wheels, plugin: odometry, model: differential, track_m: 0.5 },
            { name: imu, plugin: imu, base_T_sensor: { xyz_m: [0, 0, 0] } },
            { name: gps, plugin: dgps, base_p_antenna_m: none, sigma_m: 0.2 },
            { name: compass, plugin: compass, declination: none, base_T_sensor: { xyz_m: [0, 0, 0] } }] })";
enum Sensor : std::uint32_t { kWheels, kImu, kGps, kCompass };

/// What a robot measures; a test makes its mistake in it. And what is true.
struct Readings {
  double t = 0.0;      // [s]
  double yaw = 0.0;    // [rad]
  double speed = 0.0;  // [m/s]
  double rate = 0.0;   // [rad/s]
  WheelSpeeds wheels = {};
  ImuSample imu = {};
  GnssFix gps = {};
  CompassHeading compass = {};
};

struct Examined {
  std::vector<Finding> findings;
  std::vector<std::string> named() const {
    std::vector<std::string> names;
    for (const Finding& finding : findings) {
      if (finding.certainty == Finding::Certainty::named) names.push_back(finding.sensors.front());
    }
    return names;
  }
};

/// Drives in curves of changing direction and lets the diagnosis see it. `delay_s`: of the compass's stamps.
/// `imu_every`: steps of 0.02 s between two measurements of the IMU. `chirp` [rad/s²]: ever faster turns, since
/// periodic ones look alike at other times. `compass_until` [s]: it delivers nothing from then on.
Examined examine(const std::function<void(Readings&)>& mistake, const std::string& yaml = kYaml, double delay_s = 0.0,
                 int imu_every = 1, double chirp = 0.0, double compass_until = kLength) {
  const Robot robot = Robot::live(Config::parse(yaml, "robot.yaml"), PluginLoader({WAYMARK_PLUGIN_DIR}));
  Diagnosis diagnosis(robot);
  std::mt19937 dice(7);
  std::normal_distribution<double> noise(0.0, 1.0);
  double x = 0.0;
  double y = 0.0;
  double yaw = 0.3;
  MeasurementFeed feed(diagnosis);
  for (int k = 0; k < kLength * 50; ++k) {
    const double t = 0.02 * k;
    const double speed = 1.0 + 0.4 * std::sin(0.31 * t);
    const double rate = 0.4 * std::sin(0.23 * t + chirp * t * t) + 0.3 * std::sin(0.9 * t);
    x += 0.02 * speed * std::cos(yaw);
    y += 0.02 * speed * std::sin(yaw);
    yaw += 0.02 * rate;
    Readings readings{.t = t, .yaw = yaw, .speed = speed, .rate = rate};
    readings.wheels.left_mps = speed - 0.25 * rate + 0.02 * noise(dice);
    readings.wheels.right_mps = speed + 0.25 * rate + 0.02 * noise(dice);
    readings.imu.w_sensor = {0.0, 0.0, rate + 0.003 + 0.01 * noise(dice)};
    readings.imu.f_sensor = {0.124 * std::cos(0.31 * t) + 0.05 * noise(dice), speed * rate, 9.81};
    readings.gps.p_map_antenna = {x + 0.1 * noise(dice), y + 0.1 * noise(dice), 0.0};
    readings.compass.heading_rad = std::remainder(0.5 * M_PI - yaw + 0.02 * noise(dice), 2.0 * M_PI);
    mistake(readings);
    feed.pass(kWheels, t, std::make_shared<WheelSpeeds>(readings.wheels));
    if (k % imu_every == 0) feed.pass(kImu, t, std::make_shared<ImuSample>(readings.imu));
    if (k % 25 == 0) feed.pass(kGps, t, std::make_shared<GnssFix>(readings.gps));
    if (k % 5 == 0 && t < compass_until)
      feed.pass(kCompass, t + delay_s, std::make_shared<CompassHeading>(readings.compass));
  }
  diagnosis.finish();
  return {diagnosis.findings()};
}

/// The number that follows a text; NaN if the text is not there.
double number_after(const std::string& text, const std::string& line) {
  const std::size_t at = line.find(text);
  return at == std::string::npos ? std::nan("") : std::stod(line.substr(at + text.size()));
}

TEST(Diagnosis, FindsNothingOnARobotWithoutAMistake) {
  const Examined examined = examine([](Readings&) {});
  for (const Finding& finding : examined.findings) ADD_FAILURE() << describe(finding);
}

TEST(Diagnosis, FindsNothingWrongWithAnImuOfTwoAndAHalfHertz) {
  const Examined examined = examine([](Readings&) {}, kYaml, 0.0, 20);
  for (const Finding& finding : examined.findings) ADD_FAILURE() << describe(finding);
}

TEST(Diagnosis, NamesWheelsThatAreSwapped) {
  EXPECT_THAT(examine([](Readings& r) { std::swap(r.wheels.left_mps, r.wheels.right_mps); }).named(),
              ElementsAre("wheels"));
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
  std::string yaml = kYaml;
  yaml.replace(yaml.find("0.5"), 3, "0.7");
  const Examined examined = examine([](Readings&) {}, yaml);
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
  std::string yaml = kYaml;
  yaml.replace(yaml.rfind("xyz_m: [0, 0, 0]"), 16, "yaw_deg: -90");
  const Examined examined = examine([](Readings&) {}, yaml);
  ASSERT_THAT(examined.named(), ElementsAre("compass"));
  EXPECT_NEAR(number_after("sensors.compass.base_T_sensor.yaw_deg: ", examined.findings.front().change), 0.0, 3.0);
}

/// What a heading may be off depends on the σ that it claims.
TEST(Diagnosis, NamesACompassThatIsOffByEightDegreesIfItClaimsOne) {
  const auto off = [](Readings& r) { r.compass.heading_rad += 8.0 * M_PI / 180.0; };
  for (const Finding& finding : examine(off).findings) ADD_FAILURE() << describe(finding);
  std::string yaml = kYaml;
  yaml.replace(yaml.find("declination: none"), 17, "declination: none, sigma_deg: 1");
  EXPECT_THAT(examine(off, yaml).named(), ElementsAre("compass"));
  EXPECT_THAT(examine([](Readings&) {}, yaml).named(), ElementsAre());
}

TEST(Diagnosis, NamesACompassThatCountsTheOtherWay) {
  EXPECT_THAT(examine([](Readings& r) { r.compass.heading_rad *= -1.0; }).named(), ElementsAre("compass"));
}

TEST(Diagnosis, NamesSwappedEastAndNorth) {
  EXPECT_THAT(examine([](Readings& r) { std::swap(r.gps.p_map_antenna.x(), r.gps.p_map_antenna.y()); }).named(),
              ElementsAre("gps"));
}

TEST(Diagnosis, NamesSwappedLatitudeAndLongitudeBesideWheelsAlone) {
  std::string yaml = kYaml;
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
      yaml);
  ASSERT_THAT(examined.named(), ElementsAre("gps"));
  EXPECT_EQ(examined.findings.front().change, "source: swap latitude_deg and longitude_deg of gps");
}

TEST(Diagnosis, FitsTheDelayOfASensor) {
  const Examined examined = examine([](Readings&) {}, kYaml, 0.6);
  ASSERT_THAT(examined.named(), ElementsAre("compass"));
  EXPECT_NEAR(number_after("sensors.compass.delay_s: ", examined.findings.front().change), 0.6, 0.05);
}

TEST(Diagnosis, AnAntennaAheadOfTheBaseTurnsEarlierWithoutADelay) {
  constexpr double kAhead = 0.9;
  std::string yaml = kYaml;
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
      yaml);
  for (const Finding& finding : examined.findings) ADD_FAILURE() << describe(finding);
}

TEST(Diagnosis, FitsAnAntennaBesideAGyroWithABias) {
  constexpr double kLeft = 0.8;
  std::string yaml = kYaml;
  yaml.replace(yaml.find("base_p_antenna_m: none"), 22, "base_p_antenna_m: [0, -0.8, 0]");
  const Examined examined = examine(
      [&](Readings& r) {
        r.gps.p_map_antenna += kLeft * Eigen::Vector3d(-std::sin(r.yaw), std::cos(r.yaw), 0.0);
        r.imu.w_sensor.z() += 0.02;
      },
      yaml);
  ASSERT_THAT(examined.named(), ElementsAre("gps"));
  EXPECT_EQ(examined.findings.front().check, "lever arm");
  EXPECT_NEAR(number_after(", ", examined.findings.front().change), kLeft, 0.15) << examined.findings.front().change;
}

TEST(Diagnosis, NamesAReceiverWhoseCourseIsNotTheDirectionOfItsPath) {
  const Examined examined = examine([](Readings& r) {
    r.gps.speed_mps = r.speed;
    r.gps.course_rad = std::remainder(0.5 * M_PI - r.yaw + 1.5, 2.0 * M_PI);
  });
  ASSERT_THAT(examined.named(), ElementsAre("gps"));
  EXPECT_EQ(examined.findings.front().check, "course");
}

TEST(Diagnosis, NamesAClockThatIsSecondsAhead) {
  const Examined examined = examine([](Readings&) {}, kYaml, 18.0, 1, 8e-4);
  ASSERT_THAT(examined.named(), ElementsAre("compass"));
  EXPECT_THAT(examined.findings.front().seen, HasSubstr("leap seconds"));
  EXPECT_EQ(number_after("sensors.compass.delay_s: ", examined.findings.front().change), 18.0);
}

TEST(Diagnosis, NamesAnImuOnItsHeadInSpace) {
  std::string yaml = kYaml;
  yaml.replace(yaml.find("initial:"), 8, "motion: { kind: spatial }, initial:");
  const Examined examined = examine(
      [](Readings& r) {
        r.imu.f_sensor.z() = -9.81;
        r.imu.w_sensor.z() *= -1.0;
      },
      yaml);
  ASSERT_THAT(examined.named(), ElementsAre("imu"));
  EXPECT_EQ(examined.findings.front().check, "gravity");
}

TEST(Diagnosis, NamesAReceiverThatRepeatsItsLastFix) {
  Eigen::Vector3d last = Eigen::Vector3d::Zero();
  const Examined examined = examine([&](Readings& r) {
    if (r.t < 120.0) last = r.gps.p_map_antenna;
    r.gps.p_map_antenna = last;
  });
  ASSERT_THAT(examined.named(), testing::Contains("gps"));
  EXPECT_EQ(examined.findings.front().check, "frozen");
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
  const Examined examined = examine([](Readings&) {}, kYaml, 0.0, 1, 0.0, 120.0);
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
  const Examined examined = examine([](Readings&) {}, kYaml, 3600.0);
  ASSERT_THAT(examined.named(), ElementsAre("compass"));
  EXPECT_THAT(examined.findings.front().change, HasSubstr("{ offset_s: -3600 }"));
}

TEST(Diagnosis, NamesASensorThatDeliversNothing) {
  std::string yaml = kYaml;
  yaml.replace(yaml.rfind("] }"), 3, ", { name: second, plugin: compass, declination: none, base_T_sensor: {} }] }");
  const Examined examined = examine([](Readings&) {}, yaml);
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
  const Examined examined = examine([](Readings& r) { r.imu.w_sensor.z() *= -1.0; }, yaml);
  ASSERT_EQ(examined.findings.size(), 1u);
  EXPECT_EQ(examined.findings.front().certainty, Finding::Certainty::one_of);
  EXPECT_THAT(examined.findings.front().sensors, testing::UnorderedElementsAre("wheels", "imu"));
}

}  // namespace
}  // namespace waymark::host
