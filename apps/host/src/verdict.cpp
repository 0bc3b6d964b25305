// SPDX-License-Identifier: Apache-2.0
#include "verdict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>

#include "live_input.hpp"

namespace waymark::host {

std::vector<std::string> failures_of(const SessionResult& result, const std::vector<std::string>& of_sinks) {
  std::vector<std::string> failures;
  if (!result.log_error.empty()) failures.push_back(result.log_error);
  // The last event names the cause of a missing start, unless the log ended early.
  const bool names_cause = !result.started && result.log_error.empty() && !result.report.interrupted;
  std::string ended;  // the sources of a running robot that failed
  for (const Event& event : result.report.events) {
    if (event.text.starts_with(kSourceEnded)) ended += "; " + event.text;
    const bool is_cause = names_cause && &event == &result.report.events.back();
    if (event.is_failure || is_cause)
      failures.push_back(fmt::format("at {} s: {}{}", format_time(event.stamp, 3), event.text, is_cause ? ended : ""));
  }
  failures.insert(failures.end(), of_sinks.begin(), of_sinks.end());
  return failures;
}

std::vector<MatchReport> matches_of(const Snapshot& last) {
  std::vector<MatchReport> reports;
  if (!last.started()) return reports;
  for (const MapDescription& map : last.best_maps(MapDetail::summary)) {
    const auto figure = [&](std::string_view name) {
      const auto found = std::ranges::find(map.figures, name, &MapFigure::name);
      return found == map.figures.end() ? std::optional<std::uint64_t>{} : static_cast<std::uint64_t>(found->value);
    };
    const auto matches = figure("matches");
    const auto failed = figure("failed_matches");
    if (matches && failed) reports.push_back({map.module, *matches, *failed, figure("coarse_searches").value_or(0)});
  }
  return reports;
}

std::string lost_of(const HealthTimes& times, double allowed) {
  constexpr double kFewSeconds = 5.0;  // of a short run, or after its pose was set: no verdict
  if (times.lost_s < kFewSeconds || times.lost_share() <= allowed) return {};
  return fmt::format("the pose was lost for {:.1f} s, {:.0f} % of the run; health.max_lost_share allows {:.0f} %",
                     times.lost_s, 100.0 * times.lost_share(), 100.0 * allowed);
}

}  // namespace waymark::host
