// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

/// Messages of ROS; their definitions are in the packages of these names.
namespace waymark::ros::builtin_interfaces {

/// Seconds and nanoseconds since 1970.
struct Time {
  static constexpr std::string_view kType = "builtin_interfaces/msg/Time";
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;

  bool operator==(const Time&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("sec", self.sec);
    field("nanosec", self.nanosec);
  }
};

struct Duration {
  static constexpr std::string_view kType = "builtin_interfaces/msg/Duration";
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;

  bool operator==(const Duration&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("sec", self.sec);
    field("nanosec", self.nanosec);
  }
};

}  // namespace waymark::ros::builtin_interfaces

namespace waymark::ros::std_msgs {

/// Stamp and frame. The sequence number of ROS 1 is skipped.
struct Header {
  static constexpr std::string_view kType = "std_msgs/msg/Header";
  builtin_interfaces::Time stamp;
  std::string frame_id;

  bool operator==(const Header&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("stamp", self.stamp);
    field("frame_id", self.frame_id);
  }
};

struct ColorRGBA {
  static constexpr std::string_view kType = "std_msgs/msg/ColorRGBA";
  float r = 0.0f;
  float g = 0.0f;
  float b = 0.0f;
  float a = 0.0f;

  bool operator==(const ColorRGBA&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("r", self.r);
    field("g", self.g);
    field("b", self.b);
    field("a", self.a);
  }
};

}  // namespace waymark::ros::std_msgs

namespace waymark::ros::rosgraph_msgs {

/// The time of a simulation.
struct Clock {
  static constexpr std::string_view kType = "rosgraph_msgs/msg/Clock";
  builtin_interfaces::Time clock;

  bool operator==(const Clock&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("clock", self.clock);
  }
};

}  // namespace waymark::ros::rosgraph_msgs
