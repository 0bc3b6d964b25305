// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "exact_stamp.hpp"
#include "plugins/shared/run_views/health_changes.hpp"

namespace waymark::diagnostics {

/// The health in the document: how long each state lasted, and when that of the whole and of each sensor changed.
inline nlohmann::ordered_json health_json(const run_views::HealthChanges& health, const RunReport& report) {
  using Json = nlohmann::ordered_json;
  Json changes = Json::array();
  for (const auto& change : health.changes()) {
    const std::string who = change.sensor < report.sensors.size() ? report.sensors[change.sensor].name : "all";
    changes.push_back(
        {{"t_s", ExactStamp::json(change.stamp)}, {"of", who}, {"state", change.state}, {"reason", change.reason}});
  }
  return {{"ok_s", report.health.ok_s},
          {"degraded_s", report.health.degraded_s},
          {"lost_s", report.health.lost_s},
          {"changes", std::move(changes)},
          {"changes_left_out", health.left_out()}};
}

}  // namespace waymark::diagnostics
