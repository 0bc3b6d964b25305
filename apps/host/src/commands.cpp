// SPDX-License-Identifier: Apache-2.0
#include "commands.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <exception>
#include <numbers>
#include <optional>
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
const std::vector<std::string> kCommands{"enable",    "disable",    "shadow", "set", "set-pose",
                                         "save-maps", "checkpoint", "status", "stop"};
constexpr std::string_view kDropped = "dropped";
constexpr std::string_view kMissing = "missing";

std::vector<std::string> words_of(std::string_view text) {
  std::istringstream stream{std::string(text)};
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

/// A sensor or a map of the robot, by its name, or by "sensors.name" or "maps.name" if both have it.
struct Part {
  std::optional<std::uint32_t> sensor;
  std::optional<std::size_t> map;
};

Part part_of(std::string_view name, const Robot& robot) {
  constexpr std::string_view kSensors = "sensors.";
  constexpr std::string_view kMaps = "maps.";
  const bool is_sensor = name.starts_with(kSensors);
  const bool is_map = name.starts_with(kMaps);
  const std::string_view plain = name.substr(is_sensor ? kSensors.size() : is_map ? kMaps.size() : 0);
  Part part;
  if (const int sensor = robot.rig.find(std::string(plain)); sensor >= 0 && !is_map)
    part.sensor = static_cast<std::uint32_t>(sensor);
  const auto map = std::ranges::find(robot.maps, plain, &MapSlot::name);
  if (map != robot.maps.end() && !is_sensor) part.map = static_cast<std::size_t>(map - robot.maps.begin());
  if (part.sensor && part.map)
    throw Error(fmt::format("\"{}\" is a sensor and a map: sensors.{} or maps.{} is expected", name, name, name));
  if (part.sensor || part.map) return part;
  std::vector<std::string> names;
  for (const SensorSlot& slot : robot.sensors) names.push_back(slot.name);
  for (const MapSlot& slot : robot.maps) names.push_back(slot.name);
  throw Error(fmt::format("there is no sensor or map \"{}\"; there are: {}", name, fmt::join(names, ", ")));
}

std::string set_mode(const std::vector<std::string>& words, SensorMode mode, Fusion& fusion, const Robot& robot) {
  if (words.size() != 2) throw Error(fmt::format("{} takes the name of one sensor or map", words.front()));
  const Part part = part_of(words[1], robot);
  if (part.map) {
    if (mode == SensorMode::shadow) throw Error("a map is on or off: only sensors are evaluated without steering");
    fusion.set_map_enabled(*part.map, mode == SensorMode::fused);
    return "ok";
  }
  if (mode != SensorMode::off && !robot.sensors[*part.sensor].enabled)
    throw Error(fmt::format("{} is switched off in the YAML (enabled: false)", words[1]));
  fusion.set_mode(*part.sensor, mode);
  return "ok";
}

std::string retune(const std::vector<std::string>& words, const CommandOutputs& outputs) {
  if (words.size() < 2) throw Error("set takes sensors.NAME.KEY=VALUE or maps.NAME.KEY=VALUE");
  outputs.retune(fmt::format("{}", fmt::join(words.begin() + 1, words.end(), " ")));
  return "ok";
}

std::string note_dropped(const std::vector<std::string>& words, Fusion& fusion, const Robot& robot) {
  const Part part = words.size() == 3 ? part_of("sensors." + words[1], robot) : Part{};
  if (!part.sensor) throw Error("dropped takes a sensor and a number");
  fusion.note_dropped(*part.sensor);
  return "ok";
}

double number(const std::string& word) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value))
    throw Error(fmt::format("\"{}\" is not a number", word));
  return value;
}

std::uint64_t whole_number(const std::string& word) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size())
    throw Error(fmt::format("\"{}\" is not a whole number", word));
  return value;
}

std::string note_missing(const std::vector<std::string>& words, const Robot& robot, const CommandOutputs& outputs) {
  const Part part = words.size() == 6 ? part_of("sensors." + words[1], robot) : Part{};
  if (!part.sensor) throw Error("missing takes a sensor and four numbers");
  outputs.note_missing(*part.sensor,
                       {number(words[4]), number(words[5]), whole_number(words[2]), whole_number(words[3])});
  return "ok";
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
                          const CommandOutputs& outputs, bool is_record) {
  if (words.empty()) throw Error("an empty command");
  for (const auto& [name, mode] : kModes) {
    if (words.front() == name) return set_mode(words, mode, fusion, robot);
  }
  if (words.front() == "set-pose") return set_pose(words, fusion);
  if (words.front() == "set") return retune(words, outputs);
  if (words.front() == kDropped && is_record) return note_dropped(words, fusion, robot);
  if (words.front() == kMissing && is_record) return note_missing(words, robot, outputs);
  const std::string nearest = nearest_name(words.front(), kCommands);
  if (words.size() > 1 && std::ranges::find(kCommands, words.front()) != kCommands.end())
    throw Error(fmt::format("\"{}\" takes no arguments", words.front()));
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
  if (words.front() == "set-pose" || words.front() == "set") return true;
  if (words.front() == kDropped || words.front() == kMissing) return true;
  for (const auto& [name, mode] : kModes) {
    if (words.front() == name) return true;
  }
  return false;
}

std::string dropped_command(const std::string& sensor, std::size_t count) {
  return fmt::format("{} {} {}", kDropped, sensor, count);
}

std::string missing_command(const std::string& sensor, const Gap& gap) {
  // As many digits as bring back the same numbers.
  return fmt::format("{} {} {} {} {} {}", kMissing, sensor, gap.missing, gap.count, gap.longest_s, gap.period_s);
}

std::string execute(std::string_view command, Fusion& fusion, const Robot& robot, const CommandOutputs& outputs,
                    bool is_record) {
  try {
    return execute_words(words_of(command), fusion, robot, outputs, is_record);
  } catch (const std::exception& error) {
    return fmt::format("error: {}", error.what());
  }
}

}  // namespace waymark::host
