// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/source.hpp"

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <optional>

#include "tests/fuzz/input.hpp"
#include "waymark/interface/source.hpp"

namespace waymark::fuzz {
namespace {

// A small input that delivers more is a finding: some count in it was believed.
constexpr std::size_t kMostMeasurements = 200'000;

void require(bool holds, std::string_view otherwise) {
  if (!holds) violation(otherwise);
}

void check(const Measurement& measurement, const Source& source, const Demands& demands) {
  require(measurement.payload != nullptr, "a payload is null");
  require(measurement.sensor < source.channels().size(), "a measurement belongs to no channel");
  require(measurement.payload->type() == source.channels()[measurement.sensor].payload_type,
          "a payload is not of its channel's type");
  if (demands.valid_numbers) {
    const std::string problem = measurement.payload->problem();
    require(problem.empty(), fmt::format("a payload has bad values: {}", problem));
  }
  require(!demands.are_past || measurement.stamp - measurement.arrival <= demands.max_ahead,
          "a measurement arrives before its stamp");
}

void read_all(Source& source, const Demands& demands) {
  std::optional<Measurement> previous;
  for (std::size_t count = 0; auto measurement = source.next(); ++count) {
    check(*measurement, source, demands);
    if (previous) {
      require(measurement->arrival >= previous->arrival, "measurements do not come in the order of arrival");
      require(!demands.in_sequence || measurement->sequence > previous->sequence, "sequence numbers do not rise");
    }
    require(count < kMostMeasurements, "the source does not end");
    require(source.progress() <= 1.0, "the progress is above 1");
    previous = std::move(measurement);
  }
  require(!source.next().has_value(), "there is a measurement after the end");
}

void check_records(const Source& source) {
  for (const BadRecord& record : source.bad_records()) {
    require(!record.place.empty() && !record.reason.empty(), "a bad record has no place or no reason");
    require(record.reason.find('\n') == std::string::npos, "a bad record is not one line: " + record.reason);
  }
  for (const std::string& notice : source.notices())
    require(notice.find('\n') == std::string::npos, "a notice is not one line: " + notice);
  if (const auto reference = source.reference()) {
    for (const Reference::Point& point : reference->trajectory)
      require(point.T_map_base.p.allFinite(), "the reference has a pose that is not finite");
    for (const Reference::Landmark& landmark : reference->landmarks)
      require(landmark.p_map.allFinite(), "the reference has a landmark that is not finite");
  }
}

}  // namespace

void read_source(const PluginDescriptor& plugin, const std::string& yaml, const Rig& rig, const Demands& demands) {
  const auto run = [&] {
    const Config config = Config::parse(yaml, (folder() / "source.yaml").string());
    const std::unique_ptr<Source> source(static_cast<Source*>(plugin.create(config, rig)));
    config.reject_unread();
    try {
      read_all(*source, demands);
    } catch (const Error&) {
      check_records(*source);
      throw;
    }
    check_records(*source);
  };
  expect_value_or_error(run, folder().string());
}

}  // namespace waymark::fuzz
