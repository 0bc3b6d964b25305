// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/command/sensor_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "waymark/interface/sensor_summary.hpp"

namespace waymark::command {

std::vector<std::string> sensor_table(const RunReport& report) {
  constexpr std::size_t kColumns = 7;
  using Row = std::array<std::string, kColumns>;
  std::vector<Row> rows{{"sensor", "rate", "measured", "used", "rejected", "NIS/dof", "verdict"}};
  for (const SensorReport& sensor : report.sensors) {
    const SensorSummary summary = summarize(sensor);
    rows.push_back({summary.name, fmt::format("{:.3g} Hz", summary.rate_hz), fmt::format("{}", summary.measurements),
                    fmt::format("{}", summary.used), fmt::format("{}", summary.rejected),
                    std::isfinite(summary.nis_ratio) ? fmt::format("{:.2f}", summary.nis_ratio) : "-",
                    summary.verdict});
  }
  if (rows.size() == 1) return {};
  std::array<std::size_t, kColumns> widths{};
  for (const Row& row : rows) {
    for (std::size_t i = 0; i < kColumns; ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::vector<std::string> lines;
  for (const Row& row : rows) {
    std::string& line = lines.emplace_back(fmt::format("  {:<{}}", row[0], widths[0]));
    for (std::size_t i = 1; i + 1 < kColumns; ++i) line += fmt::format("  {:>{}}", row[i], widths[i]);
    line += "  " + row.back();
  }
  return lines;
}

}  // namespace waymark::command
