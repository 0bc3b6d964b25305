// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "tests/unit/apps/host/diagnosis/measurement_feed.hpp"
#include "waymark/host/diagnosis.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::host {

inline constexpr double kLength = 200.0;  // [s]
inline constexpr const char* kCurvingRobot = R"({ initial: { x_m: 0, y_m: 0, yaw_deg: 0 },
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
  std::shared_ptr<Payload> odometry = {};  ///< if given: what `wheels` delivers instead
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

/// How the robot drives, and what its sensors do besides.
struct Drive {
  std::string yaml = kCurvingRobot;
  double compass_late_s = 0.0;  ///< of its stamps
  double imu_late_s = 0.0;
  double gps_late_s = 0.0;
  double wheels_late_s = 0.0;
  int imu_every = 1;                 ///< steps of 0.02 s between two measurements of the IMU
  double chirp = 0.0;                ///< [rad/s²], ever faster turns, since periodic ones look alike at other times
  double compass_until_s = kLength;  ///< it delivers nothing from then on
  double imu_clock_fast = 0.0;       ///< seconds of its stamps in one of the others, less one
  double turns = 1.0;                ///< so many times as sharp
  double stands_until_s = 0.0;       ///< it stands still before
  bool reverses = false;  ///< of each 20 s it drives backwards for 6 s, and stands for a second before and after
};

/// Drives in curves of changing direction, and gives the diagnosis what the sensors measure.
inline Examined examine(const std::function<void(Readings&)>& mistake, const Drive& drive = {}) {
  const Robot robot = Robot::live(Config::parse(drive.yaml, "robot.yaml"), PluginLoader({WAYMARK_PLUGIN_DIR}));
  Diagnosis diagnosis(robot);
  std::mt19937 dice(7);
  std::normal_distribution<double> noise(0.0, 1.0);
  double x = 0.0;
  double y = 0.0;
  double yaw = 0.3;
  MeasurementFeed feed(diagnosis);
  for (int k = 0; k < kLength * 50; ++k) {
    const double t = 0.02 * k;
    const double phase = drive.reverses ? std::fmod(t, 20.0) : 0.0;
    const bool stands = (phase > 11.0 && phase < 12.0) || phase > 19.0;
    const double moves = t < drive.stands_until_s || stands ? 0.0 : 1.0;
    const double speed = (phase > 11.0 ? -1.0 : 1.0) * moves * (1.0 + 0.4 * std::sin(0.31 * t));
    const double rate =
        moves * drive.turns * (0.4 * std::sin(0.23 * t + drive.chirp * t * t) + 0.3 * std::sin(0.9 * t));
    x += 0.02 * speed * std::cos(yaw);
    y += 0.02 * speed * std::sin(yaw);
    yaw += 0.02 * rate;
    Readings readings{.t = t, .yaw = yaw, .speed = speed, .rate = rate};
    readings.wheels.left_mps = speed - 0.25 * rate + moves * 0.02 * noise(dice);
    readings.wheels.right_mps = speed + 0.25 * rate + moves * 0.02 * noise(dice);
    readings.imu.w_sensor = {0.0, 0.0, rate + 0.003 + 0.01 * noise(dice)};
    readings.imu.f_sensor = {moves * 0.124 * std::cos(0.31 * t) + 0.05 * noise(dice), speed * rate, 9.81};
    readings.gps.p_map_antenna = {x + 0.1 * noise(dice), y + 0.1 * noise(dice), 0.0};
    readings.compass.heading_rad = std::remainder(0.5 * M_PI - yaw + 0.02 * noise(dice), 2.0 * M_PI);
    mistake(readings);
    const double wheels_stamp = t + drive.wheels_late_s;
    if (readings.odometry) {
      feed.pass(kWheels, wheels_stamp, readings.odometry);
    } else {
      feed.pass(kWheels, wheels_stamp, std::make_shared<WheelSpeeds>(readings.wheels));
    }
    const double imu_stamp = t * (1.0 + drive.imu_clock_fast) + drive.imu_late_s;
    if (k % drive.imu_every == 0) feed.pass(kImu, imu_stamp, std::make_shared<ImuSample>(readings.imu));
    if (k % 25 == 0) feed.pass(kGps, t + drive.gps_late_s, std::make_shared<GnssFix>(readings.gps));
    if (k % 5 == 0 && t < drive.compass_until_s)
      feed.pass(kCompass, t + drive.compass_late_s, std::make_shared<CompassHeading>(readings.compass));
  }
  diagnosis.finish();
  return {diagnosis.findings()};
}

/// The YAML without one of its sensors.
inline std::string without(std::string yaml, const std::string& sensor) {
  return yaml.replace(yaml.find("name: " + sensor), 6, "enabled: false, name: ");
}

/// The number that follows a text; NaN if the text is not there.
inline double number_after(const std::string& text, const std::string& line) {
  const std::size_t at = line.find(text);
  return at == std::string::npos ? std::nan("") : std::stod(line.substr(at + text.size()));
}

}  // namespace waymark::host
