// SPDX-License-Identifier: Apache-2.0
#include "waymark/testing/source_contract.hpp"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <vector>

#include "findings.hpp"
#include "payload_content.hpp"

namespace waymark::testing {

namespace {

using Records = std::vector<std::string>;

/// All that a measurement says, exactly.
std::string record_of(const Measurement& m, const SourceSetting& setting) {
  std::string record = fmt::format("{} {} {} {} ", m.stamp.time_since_epoch().count(),
                                   m.arrival.time_since_epoch().count(), m.sensor, m.sequence);
  if (!m.payload) return record;
  record += m.payload->type();
  const std::string known = content_of(*m.payload);
  return record + (known.empty() && setting.content ? setting.content(*m.payload) : known);
}

/// Reads on to the end or for `count` measurements.
Records read(Source& source, std::size_t count, const SourceSetting& setting) {
  Records records;
  while (records.size() < count) {
    const auto measurement = source.next();
    if (!measurement) break;
    records.push_back(record_of(*measurement, setting));
  }
  return records;
}

std::string channels_of(const Source& source) {
  std::string text;
  for (const Channel& channel : source.channels()) text += channel.sensor + "\n" + channel.payload_type + "\n";
  return text;
}

void check_channels(const Source& source, Findings& findings) {
  findings.require(!source.channels().empty(), "the source has no channels");
  for (const Channel& channel : source.channels()) {
    findings.require(!channel.sensor.empty() && !channel.payload_type.empty(),
                     "a channel has no sensor or no payload type");
  }
}

void check_measurement(const Measurement& m, const std::optional<Measurement>& previous, const Source& source,
                       Findings& findings) {
  const std::string where = fmt::format("measurement {}", m.sequence);
  if (!m.payload) {
    findings.add("a payload is null", where);
    return;
  }
  if (m.sensor >= source.channels().size()) {
    findings.add("a measurement belongs to no channel", where);
  } else {
    findings.require(m.payload->type() == source.channels()[m.sensor].payload_type,
                     "a payload is not of its channel's type", where);
  }
  const std::string problem = m.payload->problem();
  findings.require(problem.empty(), "a payload has bad values", where + ": " + problem);
  findings.require(m.arrival >= m.stamp, "a measurement arrives before its stamp", where);
  if (!previous) return;
  findings.require(m.arrival >= previous->arrival, "measurements do not come in the order of arrival", where);
  findings.require(m.sequence > previous->sequence, "sequence numbers do not rise", where);
}

/// Reads everything once, looking at each measurement.
Records check_log(Source& source, const SourceSetting& setting, Findings& findings) {
  Records records;
  std::optional<Measurement> previous;
  double progress = source.progress();
  while (auto measurement = source.next()) {
    check_measurement(*measurement, previous, source, findings);
    const double now = source.progress();
    findings.require(std::isfinite(now) && now <= 1.0 && now >= progress, "progress leaves 0..1 or falls",
                     fmt::format("{} after {}", now, progress));
    progress = now;
    records.push_back(record_of(*measurement, setting));
    previous = std::move(measurement);
    if (records.size() > setting.most) {
      findings.add("the source does not end", fmt::format("more than {} measurements", setting.most));
      return {};
    }
  }
  for (int i = 0; i < 3; ++i) findings.require(!source.next().has_value(), "next gives something after the end");
  findings.require(!records.empty(), "the source gives no measurement, so nothing was checked");
  return records;
}

void check_reference(const Source& source, Findings& findings) {
  for (const BadRecord& record : source.bad_records()) {
    findings.require(!record.place.empty() && !record.reason.empty(), "a bad record has no place or no reason");
  }
  const auto reference = source.reference();
  if (!reference) return;
  const Reference::Point* previous = nullptr;
  for (const Reference::Point& point : reference->trajectory) {
    findings.require(point.T_map_base.p.allFinite() && point.T_map_base.q.coeffs().allFinite(),
                     "the reference has a pose that is not finite");
    findings.require(previous == nullptr || point.stamp >= previous->stamp,
                     "the reference is not in the order of time");
    previous = &point;
  }
  for (const Reference::Landmark& landmark : reference->landmarks) {
    findings.require(landmark.p_map.allFinite() && !std::isinf(landmark.radius_m),
                     "the reference has a landmark at no finite place", landmark.name);
  }
}

}  // namespace

Violations check_source(const MakeSource& make_source, const SourceSetting& setting) {
  Findings findings;
  findings.part("the check", [&] {
    const auto first = make_source();
    const auto second = make_source();
    if (!first || !second || first == second) {
      findings.add("make_source gives null or the same source twice");
      return;
    }
    check_channels(*first, findings);
    findings.require(channels_of(*first) == channels_of(*second), "two instances have different channels");
    const Records expected = check_log(*first, setting, findings);
    if (expected.empty()) return;
    check_reference(*first, findings);
    findings.require(read(*second, expected.size() + 1, setting) == expected,
                     "two instances give different measurements");
  });
  return findings.take();
}

}  // namespace waymark::testing
