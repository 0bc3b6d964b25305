// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "exact_stamp.hpp"
#include "waymark/interface/health.hpp"
#include "waymark/interface/snapshot.hpp"

namespace waymark::diagnostics {

/// When the health of the whole and of each sensor changed.
class HealthLog {
 public:
  void look(Time t, const Health& health) {
    if (health.state != whole_) {
      whole_ = health.state;
      note(t, kWhole, to_string(health.state), health.reason);
    }
    sensors_.resize(health.sensors.size(), SensorHealth::State::ok);
    for (std::size_t i = 0; i < sensors_.size(); ++i) {
      const SensorHealth& sensor = health.sensors[i];
      if (sensor.state == sensors_[i]) continue;
      sensors_[i] = sensor.state;
      note(t, i, to_string(sensor.state), sensor.reason);
    }
  }

  nlohmann::ordered_json describe(const RunReport& report) const {
    using Json = nlohmann::ordered_json;
    Json changes = Json::array();
    for (const Change& change : changes_) {
      const std::string& who = change.sensor < report.sensors.size() ? report.sensors[change.sensor].name : kAll;
      changes.push_back(
          {{"t_s", ExactStamp::json(change.t)}, {"of", who}, {"state", change.state}, {"reason", change.reason}});
    }
    return {{"ok_s", report.health.ok_s},
            {"degraded_s", report.health.degraded_s},
            {"lost_s", report.health.lost_s},
            {"changes", std::move(changes)},
            {"changes_left_out", left_out_}};
  }

 private:
  static constexpr std::size_t kMaxChanges = 1000;
  static constexpr std::size_t kWhole = static_cast<std::size_t>(-1);
  inline static const std::string kAll = "all";
  struct Change {
    Time t;
    std::size_t sensor;
    const char* state;
    std::string reason;
  };
  void note(Time t, std::size_t sensor, const char* state, const std::string& reason) {
    if (changes_.size() < kMaxChanges) {
      changes_.push_back({t, sensor, state, reason});
    } else {
      ++left_out_;
    }
  }

  Health::State whole_ = Health::State::ok;
  std::vector<SensorHealth::State> sensors_;
  std::vector<Change> changes_;
  std::size_t left_out_ = 0;
};

}  // namespace waymark::diagnostics
