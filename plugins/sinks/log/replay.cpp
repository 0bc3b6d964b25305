// SPDX-License-Identifier: Apache-2.0
#include "replay.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "waymark/config/config.hpp"
#include "waymark/io/output_file.hpp"

namespace waymark::log_sink {
namespace {

std::string number_text(double value) { return std::isfinite(value) ? fmt::format("{}", value) : std::string(); }

/// The csv source splits at every comma.
std::string word(std::string text) {
  std::ranges::replace_if(
      text, [](unsigned char c) { return c == ',' || c == '"' || c < 0x20; }, '_');
  return text;
}

}  // namespace

std::string in_quotes(std::string_view text) {
  std::string result = "\"";
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"' || c == '\\') result += '\\';
    if (text.substr(i, 2) == "${") result += '$';
    if (static_cast<unsigned char>(c) < 0x20) {
      result += fmt::format("\\x{:02x}", static_cast<unsigned>(c));
    } else {
      result += c;
    }
  }
  return result + '"';
}

std::string write_reference(const Reference& reference, const std::filesystem::path& folder, std::string_view indent) {
  std::string yaml;
  if (!reference.trajectory.empty()) {
    OutputFile file(folder / "reference_trajectory.csv");
    file.write("t_ns,x_m,y_m,yaw_rad\n");
    for (const Reference::Point& point : reference.trajectory) {
      file.write(fmt::format("{},{},{},{}\n", point.stamp.time_since_epoch().count(), point.T_map_base.p.x(),
                             point.T_map_base.p.y(), point.has_yaw ? number_text(point.T_map_base.yaw()) : ""));
    }
    file.commit();
    yaml += fmt::format(
        "{0}trajectory:\n{0}  path: reference_trajectory.csv\n{0}  empty_is_unknown: true\n"
        "{0}  columns: {{ time: {{ column: t_ns, scale: 1e-9 }}, x_m: x_m, y_m: y_m, yaw_rad: yaw_rad }}\n",
        indent);
  }
  if (!reference.landmarks.empty()) {
    OutputFile file(folder / "reference_landmarks.csv");
    file.write("name,x_m,y_m,radius_m\n");
    for (const Reference::Landmark& landmark : reference.landmarks) {
      file.write(fmt::format("{},{},{},{}\n", word(landmark.name), landmark.p_map.x(), landmark.p_map.y(),
                             number_text(landmark.radius_m)));
    }
    file.commit();
    yaml += fmt::format(
        "{0}landmarks:\n{0}  path: reference_landmarks.csv\n{0}  comment: \"\"\n{0}  empty_is_unknown: true\n"
        "{0}  columns: {{ name: name, x_m: x_m, y_m: y_m, radius_m: radius_m }}\n",
        indent);
  }
  return yaml;
}

std::string replay_config(std::string_view config, std::string_view source, const std::filesystem::path& yaml_folder,
                          const std::vector<std::size_t>& silent) {
  const Config given = Config::parse(config, "effective configuration");
  std::vector<Config::Override> overrides{"source=" + std::string(source)};
  if (given.has("base_folder")) overrides.emplace_back("base_folder=.");  // the tables lie beside it
  const std::vector<Config> sensors = given.items("sensors");
  const std::vector<Config> maps = given.items_or_empty("maps");
  for (const std::size_t sensor : silent) {
    overrides.push_back(fmt::format("sensors.{}.enabled=false", sensor));
    const std::string name = sensors.at(sensor).text("name");
    for (std::size_t i = 0; i < maps.size(); ++i) {
      // A map without its first input is refused.
      if (maps[i].texts("inputs").front() == name) overrides.push_back(fmt::format("maps.{}.enabled=false", i));
    }
  }
  for (std::size_t i = 0; i < maps.size(); ++i) {
    const std::string load = maps[i].text("load", "");
    if (load.empty()) continue;
    overrides.push_back(fmt::format("maps.{}.load={}", i, in_quotes((yaml_folder / load).lexically_normal().string())));
  }
  const std::vector<Config> sinks = given.items_or_empty("sinks");
  for (std::size_t i = 0; i < sinks.size(); ++i) {
    if (sinks[i].text("plugin", "") == "log") overrides.push_back(fmt::format("sinks.{}.enabled=false", i));
  }
  std::string folders;
  for (const std::string& folder : given.texts("plugin_path", std::vector<std::string>{})) {
    folders += (folders.empty() ? "" : ", ") + in_quotes((yaml_folder / folder).lexically_normal().string());
  }
  if (!folders.empty()) overrides.push_back(fmt::format("plugin_path=[{}]", folders));
  return Config::parse(config, "effective configuration", overrides).effective();
}

}  // namespace waymark::log_sink
