// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "plugins/shared/cdr/ros/std_msgs.hpp"

/// Messages of ROS; their definitions are in the packages of these names.
namespace waymark::ros::diagnostic_msgs {

struct KeyValue {
  static constexpr std::string_view kType = "diagnostic_msgs/msg/KeyValue";
  std::string key;
  std::string value;

  bool operator==(const KeyValue&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("key", self.key);
    field("value", self.value);
  }
};

/// Level 0: good, 1: warning, 2: error, 3: stale.
struct DiagnosticStatus {
  static constexpr std::string_view kType = "diagnostic_msgs/msg/DiagnosticStatus";
  std::byte level{};
  std::string name;
  std::string message;
  std::string hardware_id;
  std::vector<KeyValue> values;

  bool operator==(const DiagnosticStatus&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("level", self.level);
    field("name", self.name);
    field("message", self.message);
    field("hardware_id", self.hardware_id);
    field("values", self.values);
  }
};

struct DiagnosticArray {
  static constexpr std::string_view kType = "diagnostic_msgs/msg/DiagnosticArray";
  std_msgs::Header header;
  std::vector<DiagnosticStatus> status;

  bool operator==(const DiagnosticArray&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("header", self.header);
    field("status", self.status);
  }
};

}  // namespace waymark::ros::diagnostic_msgs
