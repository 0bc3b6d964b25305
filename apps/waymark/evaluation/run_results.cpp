// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/evaluation/run_results.hpp"

#include <fmt/format.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "apps/waymark/evaluation/table.hpp"
#include "waymark/base/error.hpp"
#include "waymark/config/config.hpp"
#include "waymark/io/file_stems.hpp"

namespace waymark::evaluation {
namespace {

/// The sink of this name in the configuration of a run, or an empty one.
Config sink_of(const Config& yaml, std::string_view plugin) {
  for (const Config& sink : yaml.items_or_empty("sinks")) {
    if (sink.text("plugin", "") == plugin && sink.boolean("enabled", true)) return sink;
  }
  return Config::parse("{}");
}

/// A file of the folder, or nothing if it is not there.
std::filesystem::path existing(const std::filesystem::path& folder, const std::string& name) {
  std::error_code error;
  const std::filesystem::path file = folder / name;
  return std::filesystem::is_regular_file(file, error) ? file : std::filesystem::path();
}

std::optional<Datum> datum_of(const Config& yaml, const std::filesystem::path& diagnostics) {
  if (yaml.is_mapping("datum")) {
    const Config datum = yaml.child("datum");
    return Datum{datum.number("latitude_deg"), datum.number("longitude_deg"), datum.number("height_m", 0.0)};
  }
  if (diagnostics.empty()) return std::nullopt;
  std::ifstream in(diagnostics);
  const auto document = nlohmann::json::parse(in, nullptr, false);
  if (!document.is_object() || !document.contains("datum") || !document["datum"].is_object()) return std::nullopt;
  const auto& datum = document["datum"];
  const auto number = [&](const char* name) {
    if (!datum.contains(name) || !datum[name].is_number())
      throw DataError(fmt::format("{}: datum.{} is not a number", diagnostics.string(), name));
    return datum[name].get<double>();
  };
  return Datum{number("latitude_deg"), number("longitude_deg"), number("height_m")};
}

/// Where the antenna is whose fixes were held out; nothing if there are several, or none is given.
std::optional<Eigen::Vector3d> lever_arm_of(const Config& yaml, const std::filesystem::path& held_out) {
  Table table(held_out);
  if (!table.starts_with_names({"t_s", "sensor"})) return std::nullopt;
  int column = 0;
  while (column < table.width() && table.field(0, column) != "sensor") ++column;
  if (column == table.width()) return std::nullopt;
  table.drop_first_row();
  std::set<std::string> sensors;
  for (std::size_t row = 0; row < table.rows(); ++row) sensors.insert(table.field(row, column));
  if (sensors.size() != 1) return std::nullopt;
  for (const Config& sensor : yaml.items_or_empty("sensors")) {
    if (sensor.text("name", "") != *sensors.begin() || !sensor.is_list("base_p_antenna_m")) continue;
    const std::vector<double> p = sensor.numbers("base_p_antenna_m", 3);
    return Eigen::Vector3d(p[0], p[1], p[2]);
  }
  return std::nullopt;
}

}  // namespace

RunResults find_results(const std::filesystem::path& folder) {
  std::error_code error;
  if (!std::filesystem::is_directory(folder, error))
    throw Error(fmt::format("{}: is not the output folder of a run", folder.string()));
  const std::filesystem::path config = existing(folder, std::string(kEffectiveConfigFile));
  const Config yaml = config.empty() ? Config::parse("{}") : Config::load(config);
  const Config tum = sink_of(yaml, "tum");
  RunResults found;
  found.estimate = existing(folder, tum.text("trajectory", "trajectory.txt"));
  if (found.estimate.empty())
    throw Error(fmt::format("{}: has no {}; the sink tum writes it", folder.string(),
                            tum.text("trajectory", "trajectory.txt")));
  found.covariance = existing(folder, tum.text("covariance", "covariance.csv"));
  found.diagnostics = existing(folder, sink_of(yaml, "diagnostics").text("file", "diagnostics.json"));
  found.datum = datum_of(yaml, found.diagnostics);
  found.reference = existing(folder, tum.text("reference", "reference.txt"));
  if (found.reference.empty()) {
    found.reference = existing(folder, sink_of(yaml, "held_out").text("file", "held_out.csv"));
    if (!found.reference.empty()) found.lever_arm_m = lever_arm_of(yaml, found.reference);
  }
  const Config landmarks = sink_of(yaml, "landmarks");
  found.survey = existing(folder, landmarks.text("reference_file", "reference_landmarks.csv"));
  if (!found.survey.empty()) found.landmarks = existing(folder, landmarks.text("file", "landmarks.csv"));
  if (found.landmarks.empty()) found.survey.clear();
  return found;
}

}  // namespace waymark::evaluation
