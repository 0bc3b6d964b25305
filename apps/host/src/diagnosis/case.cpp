// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "checks.hpp"

namespace waymark::host::diagnosis {

bool Case::is_blamed(std::size_t index) const {
  return std::ranges::any_of(findings, [&](const Finding& finding) {
    return finding.certainty == Finding::Certainty::named && finding.sensors.front() == sensor(index).name;
  });
}

bool Case::is_blamed(std::size_t index, std::string_view check) const {
  return std::ranges::any_of(findings, [&](const Finding& finding) {
    return finding.check == check && std::ranges::find(finding.sensors, sensor(index).name) != finding.sensors.end();
  });
}

bool Case::is_concerned(std::size_t index) const {
  return std::ranges::any_of(findings, [&](const Finding& finding) {
    return std::ranges::find(finding.sensors, sensor(index).name) != finding.sensors.end();
  });
}

bool Case::has_heights(std::size_t index) const {
  constexpr long kLeastSamples = 100;
  const bool is_ignored = sensor(index).is_altimeter() && robot.settings.motion != StateLayout::Motion::spatial;
  return sensor(index).height.samples() >= kLeastSamples && !is_ignored && !is_concerned(index);
}

double Case::setting(std::size_t index, std::string_view key) const {
  for (const Config& entry : robot.yaml.items("sensors")) {
    if (entry.text("name") == sensor(index).name && entry.has(key)) return entry.number(key);
  }
  return std::numeric_limits<double>::quiet_NaN();
}

void Case::add(Finding::Certainty certainty, std::string check, const std::vector<std::size_t>& suspects,
               std::string seen, std::string change, double sigmas) {
  Finding finding;
  finding.certainty = certainty;
  finding.check = std::move(check);
  for (const std::size_t suspect : suspects) finding.sensors.push_back(sensor(suspect).name);
  finding.seen = std::move(seen);
  finding.change = std::move(change);
  finding.sigmas = sigmas;
  finding.stamp = watch.stamp(watch.newest());
  findings.push_back(std::move(finding));
}

}  // namespace waymark::host::diagnosis
