// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/evaluation/run_comparison.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>

namespace waymark::evaluation {
namespace {

constexpr double kDegreesPerRad = 180.0 / std::numbers::pi;

struct TableColumn {
  std::string title;
  std::function<std::optional<double>(const Report&)> value;
  int decimals = 3;
};

bool is_planar(const NamedReport& one) {
  const auto& trajectory = one.report.trajectory;
  return !trajectory || trajectory->is_planar || trajectory->dimensions == 2;
}

/// A value of the trajectory's score, if there is one.
auto of_trajectory(std::function<std::optional<double>(const TrajectoryError&)> value) {
  return [value = std::move(value)](const Report& report) {
    return report.trajectory ? value(*report.trajectory) : std::optional<double>();
  };
}

std::vector<TableColumn> columns_of(bool planar) {
  const auto position = [planar](const TrajectoryError& e) -> const ErrorStatistics& {
    return planar ? e.horizontal_m : e.position_m;
  };
  const std::string kind = planar ? "plane" : "3-D";
  return {
      {kind + " rms [m]", of_trajectory([=](const TrajectoryError& e) { return std::optional(position(e).rms); }), 4},
      {"median [m]", of_trajectory([=](const TrajectoryError& e) { return std::optional(position(e).median); }), 4},
      {"max [m]", of_trajectory([=](const TrajectoryError& e) { return std::optional(position(e).max); }), 4},
      {"yaw rms [deg]", of_trajectory([](const TrajectoryError& e) {
         return e.yaw_rad ? std::optional(e.yaw_rad->rms * kDegreesPerRad) : std::nullopt;
       })},
      {"relative [m]", of_trajectory([](const TrajectoryError& e) {
         return e.relative.pairs > 0 ? std::optional(e.relative.translation_m.rms) : std::nullopt;
       }),
       4},
      {"KITTI [%]", of_trajectory([](const TrajectoryError& e) {
         return e.segments.all.segments > 0 ? std::optional(100.0 * e.segments.all.translation) : std::nullopt;
       })},
      {"[deg/m]", of_trajectory([](const TrajectoryError& e) {
         return e.segments.all.segments > 0 ? std::optional(kDegreesPerRad * e.segments.all.rotation_rad_per_m)
                                            : std::nullopt;
       }),
       5},
      {"NEES",
       [](const Report& report) {
         return report.consistency ? std::optional(report.consistency->nees.mean) : std::nullopt;
       },
       2},
      {"landmarks",
       [](const Report& report) {
         return report.landmarks ? std::optional(static_cast<double>(report.landmarks->matched)) : std::nullopt;
       },
       0},
      {"rms [m]",
       [](const Report& report) {
         return report.landmarks && report.landmarks->position_m ? std::optional(report.landmarks->position_m->rms)
                                                                 : std::nullopt;
       },
       4}};
}

}  // namespace

std::string to_table(const std::vector<NamedReport>& reports) {
  std::size_t widest = 3;
  for (const NamedReport& one : reports) widest = std::max(widest, one.name.size());
  std::vector<TableColumn> columns = columns_of(std::ranges::all_of(reports, is_planar));
  std::erase_if(columns, [&](const TableColumn& column) {
    return std::ranges::none_of(reports, [&](const NamedReport& one) { return column.value(one.report).has_value(); });
  });
  const auto width = [](const TableColumn& column) { return std::max<std::size_t>(column.title.size(), 9) + 2; };
  std::string out = fmt::format("{:<{}}", "run", widest);
  for (const TableColumn& column : columns) out += fmt::format("{:>{}}", column.title, width(column));
  out += '\n';
  for (const NamedReport& one : reports) {
    out += fmt::format("{:<{}}", one.name, widest);
    for (const TableColumn& column : columns) {
      const auto value = column.value(one.report);
      out += fmt::format("{:>{}}", value ? fmt::format("{:.{}f}", *value, column.decimals) : "-", width(column));
    }
    out += '\n';
  }
  return out;
}

std::string to_json(const std::vector<NamedReport>& reports) {
  nlohmann::ordered_json out{{"runs", nlohmann::ordered_json::array()}};
  for (const NamedReport& one : reports) {
    nlohmann::ordered_json run{{"run", one.name}};
    run.update(nlohmann::ordered_json::parse(to_json(one.report)));
    out["runs"].push_back(std::move(run));
  }
  return out.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace waymark::evaluation
