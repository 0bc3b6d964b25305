// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/command/log_diagnosis.hpp"

#include <algorithm>
#include <optional>

#include "waymark/base/error.hpp"

namespace waymark::command {

std::string diagnose_log(host::Robot& robot, host::Diagnosis& diagnosis, double until_s, double& length_s) {
  std::optional<Time> first;
  bool is_over = false;  // but for sensors that have not delivered yet
  try {
    while (std::optional<Measurement> measurement = robot.source->next()) {
      if (is_stamp(measurement->arrival)) {
        if (!first) first = measurement->arrival;
        const double passed = to_seconds(measurement->arrival - *first);
        is_over = is_over || passed > until_s;
        if (!is_over) length_s = std::max(length_s, passed);
      }
      if (is_over && diagnosis.has_all_sensors()) break;
      if (robot.is_command(*measurement) || !robot.assign(*measurement)) continue;
      if (is_over) {
        diagnosis.note(*measurement);
      } else {
        diagnosis.arrived(*measurement);
      }
    }
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

}  // namespace waymark::command
