// SPDX-License-Identifier: Apache-2.0
#include "diagnostics_message.hpp"

#include <fmt/format.h>

#include <array>
#include <utility>

#include "plugins/shared/cdr/to_ros.hpp"

namespace waymark::ros2_publisher {
namespace {

using Status = ros::diagnostic_msgs::DiagnosticStatus;

constexpr std::byte kGood{0};
constexpr std::byte kWarning{1};
constexpr std::byte kError{2};
constexpr std::byte kStale{3};

std::byte level_of(Health::State state) {
  constexpr std::array kLevels{kGood, kWarning, kError};
  return kLevels.at(static_cast<std::size_t>(state));
}
std::byte level_of(SensorHealth::State state) {
  constexpr std::array kLevels{kGood, kWarning, kError, kStale};
  return kLevels.at(static_cast<std::size_t>(state));
}

Status status_of(std::byte level, const std::string& name, std::string_view state, const std::string& reason) {
  Status status;
  status.level = level;
  status.name = "waymark: " + name;
  status.message = reason.empty() ? std::string(state) : fmt::format("{}: {}", state, reason);
  status.hardware_id = "waymark";
  return status;
}

}  // namespace

ros::diagnostic_msgs::DiagnosticArray diagnostics_message(const Health& health, const std::vector<std::string>& sensors,
                                                          Time stamp) {
  ros::diagnostic_msgs::DiagnosticArray message;
  message.header = ros::to_ros_header(stamp, "");
  Status pose = status_of(level_of(health.state), "pose", to_string(health.state), health.reason);
  pose.values.push_back({"probability_off_3_sigma", fmt::format("{:.4f}", health.probability_off_3_sigma)});
  message.status.push_back(std::move(pose));
  for (std::size_t i = 0; i < health.sensors.size() && i < sensors.size(); ++i) {
    const SensorHealth& sensor = health.sensors[i];
    message.status.push_back(status_of(level_of(sensor.state), sensors[i], to_string(sensor.state), sensor.reason));
  }
  return message;
}

}  // namespace waymark::ros2_publisher
