// SPDX-License-Identifier: Apache-2.0
// needs plugins: odometry, imu, compass
// Mistakes in the axes of an IMU, and of a magnetometer, on a robot that drives over uneven ground.
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "tests/unit/apps/host/diagnosis/measurement_feed.hpp"
#include "waymark/host/diagnosis.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::host {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr const char* kYaml = R"({ motion: { kind: spatial }, initial: { x_m: 0, y_m: 0, yaw_deg: 0 },
  datum: { latitude_deg: 49, longitude_deg: 8, height_m: 100 },
  sensors: [{ name: wheels, plugin: odometry, model: differential, track_m: 0.5 },
            { name: imu, plugin: imu, base_T_sensor: { xyz_m: [0, 0, 0] } },
            { name: compass, plugin: compass, payload: MagneticField, declination: none,
              base_T_sensor: { xyz_m: [0, 0, 0] } }] })";
enum Sensor : std::uint32_t { kWheels, kImu, kCompass };

/// What a mistake changes.
struct Readings {
  ImuSample imu = {};
  MagneticField field = {};
};

/// How much the course turns, and how steep the ground is.
struct Course {
  double turns = 1.0;
  double slopes = 1.0;
  double pitch_rad = 0.0;  ///< of the robot, all the way
};

const std::string kNoWheels = [] {
  std::string yaml = kYaml;
  return yaml.replace(yaml.find("name: wheels"), 6, "enabled: false, name: ");
}();

/// Drives with changing speed over ground whose slopes change within seconds.
std::vector<Finding> examine(const std::function<void(Readings&)>& mistake, const Course& course = {},
                             const std::string& yaml = kYaml) {
  constexpr double kStep = 0.02;
  const Robot robot = Robot::live(Config::parse(yaml, "robot.yaml"), PluginLoader({WAYMARK_PLUGIN_DIR}));
  Diagnosis diagnosis(robot);
  std::mt19937 dice(7);
  std::normal_distribution<double> noise(0.0, 1.0);
  const auto noise3 = [&] { return Eigen::Vector3d(noise(dice), noise(dice), noise(dice)); };
  const auto attitude = [&](double t) {
    const double yaw = course.turns * (2.0 * std::sin(0.21 * t) + 0.5 * std::sin(0.7 * t));
    return Eigen::AngleAxisd(0.3 + yaw, Eigen::Vector3d::UnitZ()) *
           Eigen::AngleAxisd(course.pitch_rad + course.slopes * 0.05 * std::sin(0.9 * t), Eigen::Vector3d::UnitY()) *
           Eigen::AngleAxisd(course.slopes * 0.06 * std::sin(0.61 * t + 1.0), Eigen::Vector3d::UnitX());
  };
  const auto speed = [](double t) { return 1.0 + 0.4 * std::sin(0.37 * t); };
  MeasurementFeed feed(diagnosis);
  for (int k = 0; k < 250 * 50; ++k) {
    const double t = kStep * k;
    const Eigen::Quaterniond q(attitude(t));
    const Eigen::AngleAxisd turn(q.conjugate() * attitude(t + kStep));
    const Eigen::Vector3d w = turn.axis() * turn.angle() / kStep;
    WheelSpeeds wheels;
    wheels.left_mps = speed(t) - 0.25 * w.z() + 0.01 * noise(dice);
    wheels.right_mps = speed(t) + 0.25 * w.z() + 0.01 * noise(dice);
    const Eigen::Vector3d acceleration(0.4 * 0.37 * std::cos(0.37 * t), speed(t) * w.z(), 0.0);
    Readings readings;
    readings.imu.w_sensor = w + Eigen::Vector3d(0.004, -0.003, 0.002) + 0.005 * noise3();
    readings.imu.f_sensor = acceleration + q.conjugate() * Eigen::Vector3d(0.0, 0.0, 9.81) + 0.1 * noise3();
    readings.field.m_sensor = q.conjugate() * Eigen::Vector3d(0.0, 20e-6, -44e-6) + 0.2e-6 * noise3();
    mistake(readings);
    feed.pass(kWheels, t, std::make_shared<WheelSpeeds>(wheels));
    feed.pass(kImu, t, std::make_shared<ImuSample>(readings.imu));
    if (k % 5 == 0) feed.pass(kCompass, t, std::make_shared<MagneticField>(readings.field));
  }
  diagnosis.finish();
  return diagnosis.findings();
}

/// One finding, which names one sensor and says what to change.
void expect_one(const std::vector<Finding>& findings, const char* sensor, const char* change) {
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_THAT(findings.front().sensors, ElementsAre(sensor));
  EXPECT_THAT(findings.front().change, HasSubstr(change));
}

/// Bumps and an engine.
class Shaking {
 public:
  Eigen::Vector3d operator()() { return {noise_(dice_), noise_(dice_), noise_(dice_)}; }

 private:
  std::mt19937 dice_{3};
  std::normal_distribution<double> noise_{0.0, 4.0};
};

TEST(ImuAxesDiagnosis, FindsNothingWithoutAMistake) {
  EXPECT_THAT(examine([](Readings&) {}), IsEmpty());
}

TEST(ImuAxesDiagnosis, AHeadingThatTurnsAsTheRobotTiltsContradictsNobody) {
  EXPECT_THAT(examine([](Readings&) {}, {.turns = 0.05, .slopes = 2.0}), IsEmpty());
}

TEST(ImuAxesDiagnosis, NamesASignOfTheAccelerometer) {
  const auto findings = examine([](Readings& seen) { seen.imu.f_sensor.y() *= -1.0; });
  expect_one(findings, "imu", "the sign of f_y_mps2");
}

TEST(ImuAxesDiagnosis, NamesAxesOfTheAccelerometerThatAreSwapped) {
  const auto findings = examine([](Readings& seen) { std::swap(seen.imu.f_sensor.x(), seen.imu.f_sensor.y()); });
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_THAT(findings.front().change, HasSubstr("the order or the signs of f_x_mps2 and f_y_mps2"));
}

TEST(ImuAxesDiagnosis, NamesAxesOfTheGyroThatAreSwapped) {
  const auto findings = examine([](Readings& seen) { std::swap(seen.imu.w_sensor.x(), seen.imu.w_sensor.y()); });
  expect_one(findings, "imu", "the order or the signs of w_x_radps and w_y_radps");
}

TEST(ImuAxesDiagnosis, AGyroOfOneAxisIsNoMistake) {
  EXPECT_THAT(examine([](Readings& seen) { seen.imu.w_sensor.head<2>().setZero(); }), IsEmpty());
}

TEST(ImuAxesDiagnosis, FitsTheYawOfAnImuOnUnevenGround) {
  const auto findings = examine([](Readings& seen) {
    const Eigen::AngleAxisd turned(-M_PI / 6.0, Eigen::Vector3d::UnitZ());
    seen.imu.w_sensor = turned * seen.imu.w_sensor;
    seen.imu.f_sensor = turned * seen.imu.f_sensor;
  });
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings.front().check, "acceleration");
  EXPECT_THAT(findings.front().sensors, ElementsAre("imu"));
}

TEST(ImuAxesDiagnosis, NamesAFieldThatPointsUpInTheNorth) {
  const auto findings = examine([](Readings& seen) { seen.field.m_sensor.z() *= -1.0; });
  expect_one(findings, "compass", "the sign of m_z_t");
  EXPECT_EQ(findings.at(0).check, "field");
}

TEST(ImuAxesDiagnosis, NamesTheFieldWithoutAGyroOfThreeAxes) {
  const auto findings = examine([](Readings& seen) {
    seen.imu.w_sensor.head<2>().setZero();
    seen.field.m_sensor.z() *= -1.0;
  });
  expect_one(findings, "compass", "the sign of m_z_t");
}

TEST(ImuAxesDiagnosis, NamesASignOfTheAccelerometerByTheField) {
  const auto mistake = [](Readings& seen) {
    seen.imu.w_sensor.head<2>().setZero();
    seen.imu.f_sensor.y() *= -1.0;
  };
  const auto findings = examine(mistake, {.turns = 0.05, .slopes = 2.0});
  expect_one(findings, "imu", "the sign of f_y_mps2");
}

TEST(ImuAxesDiagnosis, NamesASignOfTheGyroOfAMachineThatShakes) {
  Shaking shaking;
  const auto findings = examine([&](Readings& seen) {
    seen.imu.f_sensor += shaking();
    seen.imu.w_sensor.x() *= -1.0;
  });
  expect_one(findings, "imu", "the sign of w_x_radps");
}

TEST(ImuAxesDiagnosis, AMachineThatShakesHasNoOtherUnit) {
  Shaking shaking;
  EXPECT_THAT(examine([&](Readings& seen) { seen.imu.f_sensor += shaking(); }), IsEmpty());
}

TEST(ImuAxesDiagnosis, NamesTheAxesOfAMagnetometer) {
  const auto findings = examine([](Readings& seen) { std::swap(seen.field.m_sensor.x(), seen.field.m_sensor.y()); });
  expect_one(findings, "compass", "the order or the signs of m_x_t and m_y_t");
  EXPECT_EQ(findings.at(0).check, "field");
}

TEST(ImuAxesDiagnosis, NamesTheColumnsOfAMirroredFieldOnALevelFloor) {
  const auto mistake = [](Readings& seen) {
    seen.imu.w_sensor.head<2>().setZero();
    std::swap(seen.field.m_sensor.x(), seen.field.m_sensor.y());
  };
  const auto findings = examine(mistake, {.slopes = 0.0});
  expect_one(findings, "compass", "m_x_t and m_y_t of compass");
}

TEST(ImuAxesDiagnosis, NamesAGyroInDegreesByTheField) {
  const auto findings = examine([](Readings& seen) { seen.imu.w_sensor *= 180.0 / M_PI; }, {.turns = 0.5}, kNoWheels);
  expect_one(findings, "imu", "(degrees per second)");
  EXPECT_EQ(findings.at(0).check, "field");
}

TEST(ImuAxesDiagnosis, AMagnetometerWithAnAxisOfAnotherScaleIsNoGyroOfAnotherScale) {
  const auto findings = examine([](Readings& seen) { seen.field.m_sensor.x() *= 1.8; }, {.turns = 0.5, .slopes = 0.0});
  for (const Finding& finding : findings)
    EXPECT_THAT(finding.sensors, testing::Not(testing::Contains("imu"))) << describe(finding);
}

TEST(ImuAxesDiagnosis, FitsTheYawOfAMagnetometerBesideAGyro) {
  const auto findings = examine([](Readings& seen) {
    seen.field.m_sensor = Eigen::AngleAxisd(-M_PI / 6.0, Eigen::Vector3d::UnitZ()) * seen.field.m_sensor;
  });
  expect_one(findings, "compass", "sensors.compass.base_T_sensor.yaw_deg: 30 fits");
}

TEST(ImuAxesDiagnosis, WhatFliesTiltedHasNoIron) {
  const auto thrust = [](Readings& seen) { seen.imu.f_sensor = {0.0, 0.0, seen.imu.f_sensor.z()}; };
  EXPECT_THAT(examine(thrust, {.turns = 2.0, .pitch_rad = 0.15}), IsEmpty());
}

}  // namespace
}  // namespace waymark::host
