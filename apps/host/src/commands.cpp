// SPDX-License-Identifier: Apache-2.0
#include "commands.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <charconv>
#include <cmath>
#include <exception>
#include <numbers>
#include <sstream>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "waymark/base/error.hpp"
#include "waymark/config/nearest_name.hpp"

namespace waymark::host {
namespace {

constexpr std::array<std::pair<std::string_view, SensorMode>, 3> kModes{
    {{"enable", SensorMode::fused}, {"disable", SensorMode::off}, {"shadow", SensorMode::shadow}}};
const std::vector<std::string> kCommands{"enable",    "disable",    "shadow", "set-pose",
                                         "save-maps", "checkpoint", "status", "stop"};

std::vector<std::string> words_of(std::string_view text) {
  std::istringstream stream{std::string(text)};
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

std::uint32_t sensor_of(const std::string& name, const Robot& robot) {
  const int sensor = robot.rig.find(name);
  if (sensor >= 0) return static_cast<std::uint32_t>(sensor);
  std::vector<std::string> names;
  for (const SensorSlot& slot : robot.sensors) names.push_back(slot.name);
  throw Error(fmt::format("there is no sensor \"{}\"; there are: {}", name, fmt::join(names, ", ")));
}

std::string set_mode(const std::vector<std::string>& words, SensorMode mode, Fusion& fusion, const Robot& robot) {
  if (words.size() != 2) throw Error(fmt::format("{} takes the name of one sensor", words.front()));
  const std::uint32_t sensor = sensor_of(words[1], robot);
  if (mode != SensorMode::off && !robot.sensors[sensor].enabled)
    throw Error(fmt::format("{} is switched off in the YAML (enabled: false)", words[1]));
  fusion.set_mode(sensor, mode);
  return "ok";
}

double number(const std::string& word) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value))
    throw Error(fmt::format("\"{}\" is not a number", word));
  return value;
}

std::string set_pose(const std::vector<std::string>& words, Fusion& fusion) {
  if (words.size() != 4 && words.size() != 6)
    throw Error("set-pose takes x [m], y [m] and heading [degrees], then, if known, their σ [m] and [degrees]");
  constexpr double kRadians = std::numbers::pi / 180.0;
  GivenPose pose;
  pose.position = {number(words[1]), number(words[2])};
  pose.yaw = kRadians * number(words[3]);
  if (words.size() == 6) {
    pose.position_sigma = number(words[4]);
    pose.yaw_sigma = kRadians * number(words[5]);
  }
  fusion.set_pose(pose);
  return "ok";
}

std::string execute_words(const std::vector<std::string>& words, Fusion& fusion, const Robot& robot,
                          const CommandOutputs& outputs) {
  if (words.empty()) throw Error("an empty command");
  for (const auto& [name, mode] : kModes) {
    if (words.front() == name) return set_mode(words, mode, fusion, robot);
  }
  if (words.front() == "set-pose") return set_pose(words, fusion);
  const std::string nearest = nearest_name(words.front(), kCommands);
  if (words.size() > 1) throw Error(fmt::format("\"{}\" takes no arguments", words.front()));
  if (words.front() == "save-maps" && outputs.save_maps) return "ok " + outputs.save_maps();
  if (words.front() == "checkpoint" && outputs.checkpoint) return "ok " + outputs.checkpoint();
  if (words.front() == "status" && outputs.status) return "ok " + outputs.status();
  if (words.front() == "stop" && outputs.stop) {
    outputs.stop();
    return "ok";
  }
  throw Error(fmt::format("unknown command \"{}\"{}; there are: {}", words.front(),
                          nearest.empty() ? "" : fmt::format("; did you mean \"{}\"?", nearest),
                          fmt::join(kCommands, ", ")));
}

}  // namespace

bool steers(std::string_view command) {
  const std::vector<std::string> words = words_of(command);
  if (words.empty()) return false;
  if (words.front() == "set-pose") return true;
  for (const auto& [name, mode] : kModes) {
    if (words.front() == name) return true;
  }
  return false;
}

std::string execute(std::string_view command, Fusion& fusion, const Robot& robot, const CommandOutputs& outputs) {
  try {
    return execute_words(words_of(command), fusion, robot, outputs);
  } catch (const std::exception& error) {
    return fmt::format("error: {}", error.what());
  }
}

}  // namespace waymark::host
