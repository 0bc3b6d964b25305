// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace waymark::imports {

/// One input of a node of robot_localization: `odom0`, `imu1`, ….
struct LocalizationInput {
  enum class Kind { odom, twist, imu, pose };
  /// Order of the 15 numbers that an input's `_config` switches.
  enum Number { x, y, z, roll, pitch, yaw, v_x, v_y, v_z, v_roll, v_pitch, v_yaw, a_x, a_y, a_z, kNumbers };

  Kind kind = Kind::odom;
  std::string name;  ///< "odom0"
  std::string topic;
  std::array<bool, kNumbers> fused{};  ///< which numbers the filter takes
  bool differential = false;           ///< poses count as motion between them
  bool relative = false;               ///< poses count from the first one
};

/// A channel and a sensor of the YAML.
struct ImportedSensor {
  std::string type;     ///< of the topic's messages: "nav_msgs/msg/Odometry"
  std::string payload;  ///< what is made of them; empty: the type's first
  std::string topic;
  std::string name;
  std::string keys;  ///< of the sensor, after `name`, in flow style
  bool is_motion_source = false;
  bool is_receiver = false;  ///< GPS
  std::vector<std::string> notes;
};

/// The sensors that take what the input gave; none, with notes in `dropped`, if waymark has no such input.
/// `mounting`: value of `base_T_sensor`. `fix_topic`: of the GPS receiver.
std::vector<ImportedSensor> sensors_of(const LocalizationInput& input, bool is_planar, const std::string& mounting,
                                       const std::string& fix_topic, std::vector<std::string>& dropped);

}  // namespace waymark::imports
