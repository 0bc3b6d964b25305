// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/import/robot_localization.hpp"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <utility>

#include "apps/waymark/import/localization_input.hpp"
#include "waymark/base/error.hpp"

namespace waymark::imports {
namespace {

using Input = LocalizationInput;

constexpr std::pair<Input::Kind, const char*> kKinds[] = {
    {Input::Kind::odom, "odom"}, {Input::Kind::twist, "twist"}, {Input::Kind::imu, "imu"}, {Input::Kind::pose, "pose"}};
constexpr int kMostInputs = 20;  // of one kind
constexpr std::uintmax_t kMostBytes = 1'000'000;

class Parameters {
 public:
  Parameters(std::string file, const YAML::Node& node) : file_(std::move(file)), node_(node) {}

  bool has(const std::string& key) const { return node_[key].IsDefined(); }

  template <class T>
  std::optional<T> get(const std::string& key, std::string_view expected) const {
    const YAML::Node value = node_[key];
    if (!value) return std::nullopt;
    try {
      return value.as<T>();
    } catch (const YAML::Exception&) {
      fail(value, fmt::format("{}: {} expected", key, expected));
    }
  }
  bool flag(const std::string& key) const { return get<bool>(key, "true or false is").value_or(false); }
  std::string text(const std::string& key) const { return get<std::string>(key, "a text is").value_or(""); }
  std::vector<double> numbers(const std::string& key) const {
    return get<std::vector<double>>(key, "a list of numbers is").value_or(std::vector<double>{});
  }

  [[noreturn]] void fail(const std::string& key, const std::string& problem) const { fail(node_[key], problem); }
  [[noreturn]] void fail(const YAML::Node& at, const std::string& problem) const {
    throw DataError(fmt::format("{}:{}: {}", file_, at.Mark().line + 1, problem));
  }

 private:
  std::string file_;
  YAML::Node node_;
};

bool is_filter(const YAML::Node& node) {
  if (!node.IsMap()) return false;
  return std::ranges::any_of(kKinds,
                             [&](const auto& kind) { return node[fmt::format("{}0", kind.second)].IsDefined(); });
}

/// Name -> parameters of all filters in the file: `node: { ros__parameters: … }` of ROS 2, `node: { … }` or the
/// parameters themselves of ROS 1.
std::map<std::string, YAML::Node> filters_in(const YAML::Node& root) {
  std::map<std::string, YAML::Node> found;
  if (!root.IsMap()) return found;
  if (is_filter(root)) found["(the file)"] = root;
  for (const auto& entry : root) {
    if (!entry.second.IsMap()) continue;
    const YAML::Node inner = entry.second["ros__parameters"] ? entry.second["ros__parameters"] : entry.second;
    if (is_filter(inner)) found[entry.first.as<std::string>()] = inner;
  }
  return found;
}

YAML::Node parse(const std::filesystem::path& file) {
  std::error_code error;
  const auto size = std::filesystem::file_size(file, error);
  std::ifstream in(file);
  if (error || !in) throw DataError(fmt::format("{}: cannot be read", file.string()));
  if (size > kMostBytes)
    throw DataError(fmt::format("{}: it has {} bytes; at most {} are expected", file.string(), size, kMostBytes));
  std::stringstream text;
  text << in.rdbuf();
  try {
    return YAML::Load(text.str());
  } catch (const YAML::Exception& problem) {
    throw DataError(fmt::format("{}:{}: {}", file.string(), problem.mark.line + 1, problem.msg));
  }
}

Parameters choose_filter(const std::filesystem::path& file, const std::string& wanted,
                         std::vector<std::string>& notes) {
  const YAML::Node root = parse(file);
  std::map<std::string, YAML::Node> filters = filters_in(root);
  std::string names;
  for (const auto& [name, node] : filters) names += (names.empty() ? "" : ", ") + name;
  if (filters.empty())
    throw DataError(
        fmt::format("{}: there is no filter of robot_localization in it: none has an input such as odom0 "
                    "or imu0",
                    file.string()));
  if (!wanted.empty()) {
    const auto found = filters.find(wanted);
    if (found == filters.end())
      throw DataError(fmt::format("{}: there is no filter \"{}\"; there are: {}", file.string(), wanted, names));
    return {file.string(), found->second};
  }
  if (filters.size() == 1) return {file.string(), filters.begin()->second};
  // Two filters are the usual way to have a smooth and a global pose; waymark gives both out of one.
  const auto in_map = std::ranges::find_if(filters, [](const auto& filter) {
    const YAML::Node& node = filter.second;
    return node["world_frame"] && node["map_frame"] &&
           node["world_frame"].as<std::string>("") == node["map_frame"].as<std::string>("");
  });
  if (in_map == filters.end())
    throw DataError(fmt::format("{}: there are several filters: {}; --node chooses one", file.string(), names));
  notes.push_back(
      fmt::format("of the filters {} this is {}; waymark gives the smooth pose in odom and that in the map "
                  "out of one filter",
                  names, in_map->first));
  return {file.string(), in_map->second};
}

std::vector<Input> inputs_of(const Parameters& parameters) {
  std::vector<Input> inputs;
  for (const auto& [kind, word] : kKinds) {
    for (int i = 0; i < kMostInputs; ++i) {
      Input input;
      input.kind = kind;
      input.name = fmt::format("{}{}", word, i);
      if (!parameters.has(input.name)) continue;
      input.topic = parameters.text(input.name);
      if (!input.topic.starts_with('/')) input.topic = "/" + input.topic;
      const std::string key = input.name + "_config";
      const auto fused = parameters.get<std::vector<bool>>(key, "a list of 15 times true or false is");
      if (!fused) parameters.fail(input.name, fmt::format("{} is missing", key));
      if (fused->size() != Input::kNumbers)
        parameters.fail(key, fmt::format("{} has {} entries; 15 are expected", key, fused->size()));
      std::ranges::copy(*fused, input.fused.begin());
      input.differential = parameters.flag(input.name + "_differential");
      input.relative = parameters.flag(input.name + "_relative");
      inputs.push_back(std::move(input));
    }
  }
  return inputs;
}

/// A text as a scalar of YAML.
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + '"';
}

std::string source_of(const ImportSettings& settings, const std::vector<ImportedSensor>& sensors) {
  std::string text = "source:\n";
  const std::filesystem::path& recording = settings.recording;
  const bool is_live = recording.empty();
  if (is_live) {
    text += "  plugin: ros2\n";
  } else {
    const std::string extension = recording.extension().string();
    text += fmt::format("  plugin: {}\n  file: {}\n",
                        extension == ".bag"    ? "rosbag1"
                        : extension == ".mcap" ? "mcap"
                                               : "rosbag2",
                        quoted(std::filesystem::absolute(recording).string()));
  }
  text += "  channels:\n";
  for (const ImportedSensor& sensor : sensors) {
    text += fmt::format("    - {{ topic: {}, ", sensor.topic);
    if (is_live) text += fmt::format("type: {}, ", sensor.type);
    if (!sensor.payload.empty()) text += fmt::format("payload: {}, ", sensor.payload);
    text += fmt::format("sensor: {} }}\n", sensor.name);
  }
  return text;
}

std::string start_of(const Parameters& parameters, bool has_receiver) {
  const std::vector<double> state = parameters.numbers("initial_state");
  if (state.size() == Input::kNumbers) {
    return fmt::format("initial: {{ x_m: {:g}, y_m: {:g}, yaw_deg: {:g} }}\n", state[Input::x], state[Input::y],
                       state[Input::yaw] * 180.0 / M_PI);
  }
  if (!state.empty()) parameters.fail("initial_state", fmt::format("it has {} entries; 15 are expected", state.size()));
  if (has_receiver)
    return "# The start: position from the first fix, heading from the fixes and the way between them.\n";
  return "initial: { x_m: 0, y_m: 0, yaw_deg: 0 }\n";
}

/// Both programs add it as a variance per second, so the values can be taken over.
std::string motion_of(const Parameters& parameters, bool is_planar) {
  std::string text = fmt::format("motion:\n  kind: {}\n", is_planar ? "planar" : "spatial");
  std::vector<double> Q = parameters.numbers("process_noise_covariance");
  if (Q.empty()) return text;
  if (Q.size() == Input::kNumbers * Input::kNumbers) {
    std::vector<double> diagonal;
    for (std::size_t i = 0; i < Input::kNumbers; ++i) diagonal.push_back(Q[i * (Input::kNumbers + 1)]);
    Q = std::move(diagonal);
  }
  if (Q.size() != Input::kNumbers) {
    parameters.fail("process_noise_covariance", fmt::format("it has {} entries; 15 or 225 are expected", Q.size()));
  }
  const auto sigma = [&](Input::Number number) {
    if (!(Q[number] > 0.0) || !std::isfinite(Q[number]))
      parameters.fail("process_noise_covariance",
                      fmt::format("{} on its diagonal; a number above 0 is expected", Q[number]));
    return std::sqrt(Q[number]);
  };
  return text + fmt::format(
                    "  velocity_noise_mps_per_sqrt_s: [{:.4g}, {:.4g}, {:.4g}]     # process_noise_covariance\n"
                    "  rate_noise_radps_per_sqrt_s: [{:.4g}, {:.4g}, {:.4g}]\n",
                    sigma(Input::v_x), sigma(Input::v_y), sigma(Input::v_z), sigma(Input::v_roll),
                    sigma(Input::v_pitch), sigma(Input::v_yaw));
}

std::string sinks_of(const Parameters& parameters, bool is_live) {
  if (!is_live) return "sinks: [{ plugin: tum }, { plugin: plot }, { plugin: diagnostics }]\n";
  std::string text = "sinks:\n  - plugin: ros2_publisher\n";
  for (const char* key : {"map_frame", "odom_frame"}) {
    if (const std::string frame = parameters.text(key); !frame.empty())
      text += fmt::format("    {}: {}\n", key, quoted(frame));
  }
  if (const std::string frame = parameters.text("base_link_frame"); !frame.empty())
    text += fmt::format("    base_frame: {}\n", quoted(frame));
  return text + "  - plugin: diagnostics\n";
}

void note_what_differs(const Parameters& parameters, const std::vector<Input>& inputs,
                       std::vector<std::string>& notes) {
  if (parameters.has("control_config") || parameters.flag("use_control"))
    notes.emplace_back("use_control: commands are not an input of waymark");
  if (parameters.flag("smooth_lagged_data"))
    notes.emplace_back(
        "smooth_lagged_data: late measurements are replayed without it; filter.history_s bounds how late");
  const bool has_threshold = std::ranges::any_of(inputs, [&](const Input& input) {
    return parameters.has(input.name + "_pose_rejection_threshold") ||
           parameters.has(input.name + "_twist_rejection_threshold");
  });
  if (has_threshold)
    notes.emplace_back("rejection thresholds: every sensor has a gate of its own (gate_probability, 0.999)");
}

}  // namespace

Imported import_robot_localization(const std::filesystem::path& file, const ImportSettings& settings) {
  Imported imported;
  const Parameters parameters = choose_filter(file, settings.node, imported.notes);
  const bool is_planar = parameters.flag("two_d_mode");
  const bool is_live = settings.recording.empty();
  const std::vector<Input> inputs = inputs_of(parameters);
  const std::string mounting = is_live ? "from_tf" : "{ xyz_m: [0, 0, 0], yaw_deg: 0 }";
  std::vector<ImportedSensor> sensors;
  for (const Input& input : inputs) {
    for (ImportedSensor& sensor : sensors_of(input, is_planar, mounting, settings.fix_topic, imported.notes))
      sensors.push_back(std::move(sensor));
  }
  if (std::ranges::none_of(sensors, &ImportedSensor::is_motion_source)) {
    throw DataError(
        fmt::format("{}: no input measures how the robot moves: velocities of wheels, an IMU, or poses of an "
                    "odometry are expected",
                    file.string()));
  }
  if (!is_live && std::ranges::any_of(inputs, [](const Input& input) { return input.kind == Input::Kind::imu; }))
    imported.notes.emplace_back("a recording does not say where the IMU is mounted: set its base_T_sensor");
  note_what_differs(parameters, inputs, imported.notes);

  std::string& yaml = imported.yaml;
  yaml = fmt::format("# From the parameters of robot_localization in {}.\n", file.filename().string());
  for (const std::string& note : imported.notes) yaml += fmt::format("# - {}\n", note);
  yaml += "\n" + source_of(settings, sensors) + "\n";
  yaml += start_of(parameters, std::ranges::any_of(sensors, &ImportedSensor::is_receiver)) + "\n";
  yaml += motion_of(parameters, is_planar) + "\nsensors:\n";
  for (const ImportedSensor& sensor : sensors) {
    for (const std::string& note : sensor.notes) yaml += fmt::format("  # {}\n", note);
    yaml += fmt::format("  - {{ name: {}, {} }}\n", sensor.name, sensor.keys);
  }
  yaml += "\n" + sinks_of(parameters, is_live);
  return imported;
}

}  // namespace waymark::imports
