// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/import/localization_input.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace waymark::imports {
namespace {

using Input = LocalizationInput;

bool measures_twist(const Input& input) {
  return input.fused[Input::v_x] || input.fused[Input::v_y] || input.fused[Input::v_yaw];
}

/// The topic of `navsat_transform`: its positions are those of a receiver's fixes.
bool is_from_receiver(const Input& input) {
  return input.topic.find("gps") != std::string::npos || input.topic.find("navsat") != std::string::npos;
}

ImportedSensor odometry(const Input& input, bool has_poses) {
  ImportedSensor sensor;
  sensor.type = has_poses ? "nav_msgs/msg/Odometry" : "geometry_msgs/msg/TwistWithCovarianceStamped";
  sensor.topic = input.topic;
  sensor.name = input.name;
  sensor.is_motion_source = true;
  sensor.keys = "plugin: odometry, model: twist";
  // What was not fused is still in the message: wide noise leaves it to the others.
  if (!input.fused[Input::v_x]) {
    sensor.keys += ", speed_noise_m_per_sqrt_s: [3, 0]";
    sensor.notes.emplace_back("v_x was not fused: its noise is wide");
  }
  if (!input.fused[Input::v_y])
    sensor.notes.emplace_back("v_y was not fused; waymark takes it, as 0 for wheels that do not slip sideways");
  if (!input.fused[Input::v_yaw]) {
    sensor.keys += ", yaw_noise_rad_per_sqrt_s: [1, 0, 0]";
    sensor.notes.emplace_back("v_yaw was not fused: its noise is wide");
  }
  sensor.notes.emplace_back("the message's covariances are not read: the noise is a key of the sensor");
  return sensor;
}

ImportedSensor increments(const Input& input, const std::string& type) {
  ImportedSensor sensor;
  sensor.type = type;
  sensor.payload = "PoseIncrement";
  sensor.topic = input.topic;
  sensor.name = input.name;
  sensor.is_motion_source = true;
  sensor.keys = "plugin: odometry, model: increment";
  if (!input.differential)
    sensor.notes.emplace_back("its poses count as motion between them, as with `differential: true`");
  return sensor;
}

ImportedSensor receiver(const Input& input, const std::string& fix_topic) {
  ImportedSensor sensor;
  sensor.type = "sensor_msgs/msg/NavSatFix";
  sensor.topic = fix_topic;
  sensor.name = "gps";
  sensor.is_receiver = true;
  sensor.keys = "plugin: dgps, base_p_antenna_m: none";
  sensor.notes.push_back(
      fmt::format("in place of {} ({}): waymark takes the receiver's own fixes, navsat_transform is "
                  "not needed",
                  input.name, input.topic));
  sensor.notes.emplace_back("base_p_antenna_m: [x, y, z] of the antenna in base_link, if you know it");
  return sensor;
}

ImportedSensor altimeter(const Input& input, const std::string& type) {
  ImportedSensor sensor;
  sensor.type = type;
  sensor.payload = "Height";
  sensor.topic = input.topic;
  sensor.name = input.name + "_height";
  sensor.keys = "plugin: altimeter, sigma_m: 0.1";
  sensor.notes.emplace_back("sigma_m is a guess");
  return sensor;
}

ImportedSensor imu(const Input& input, bool is_planar, const std::string& mounting) {
  ImportedSensor sensor;
  sensor.type = "sensor_msgs/msg/Imu";
  sensor.topic = input.topic;
  sensor.name = input.name;
  sensor.is_motion_source = true;
  sensor.keys = "plugin: imu, base_T_sensor: " + mounting;
  if (input.fused[Input::yaw])
    sensor.notes.emplace_back(
        "its yaw was fused; here its rates are. `heading: true` takes the heading instead, from the magnetometer");
  if (!is_planar)
    sensor.notes.emplace_back("roll and pitch come from its rates and accelerations, by a filter of waymark's own");
  if (input.fused[Input::a_x] || input.fused[Input::a_y])
    sensor.notes.emplace_back("accelerations are not integrated to velocities");
  return sensor;
}

}  // namespace

std::vector<ImportedSensor> sensors_of(const LocalizationInput& input, bool is_planar, const std::string& mounting,
                                       const std::string& fix_topic, std::vector<std::string>& dropped) {
  std::vector<ImportedSensor> sensors;
  const bool has_position = input.fused[Input::x] || input.fused[Input::y];
  if (input.kind == Input::Kind::imu) {
    sensors.push_back(imu(input, is_planar, mounting));
    return sensors;
  }
  if (std::ranges::none_of(input.fused, [](bool one) { return one; })) {
    dropped.push_back(fmt::format("{} ({}): nothing of it was fused", input.name, input.topic));
    return sensors;
  }
  if (input.kind == Input::Kind::pose) {
    if (has_position || input.fused[Input::yaw]) {
      dropped.push_back(
          fmt::format("{} ({}): absolute poses are not an input of waymark. A map of its own takes their "
                      "place, or the sensor behind them",
                      input.name, input.topic));
    }
    if (input.fused[Input::z] && !is_planar)
      sensors.push_back(altimeter(input, "geometry_msgs/msg/PoseWithCovarianceStamped"));
    return sensors;
  }
  const bool is_odometry = input.kind == Input::Kind::odom;
  if (measures_twist(input)) {
    sensors.push_back(odometry(input, is_odometry));
  } else if (is_odometry && has_position && is_from_receiver(input)) {
    sensors.push_back(receiver(input, fix_topic));
  } else if (is_odometry && (has_position || input.fused[Input::yaw])) {
    sensors.push_back(increments(input, "nav_msgs/msg/Odometry"));
  }
  if (is_odometry && input.fused[Input::z] && !is_planar && !is_from_receiver(input))
    sensors.push_back(altimeter(input, "nav_msgs/msg/Odometry"));
  if (sensors.empty())
    dropped.push_back(fmt::format("{} ({}): what it measures is not an input of waymark", input.name, input.topic));
  return sensors;
}

}  // namespace waymark::imports
