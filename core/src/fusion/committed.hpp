// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "estimation/smoother.hpp"
#include "fusion/sensor_record.hpp"
#include "monitoring/health_monitor.hpp"
#include "monitoring/standstill.hpp"
#include "particles/particle_filter.hpp"
#include "waymark/base/error.hpp"

namespace waymark::fusion {

/// The committed side as it was before one measurement: what a roll-back restores.
struct Mark {
  std::uint64_t at = 0;  ///< number of that measurement, from the start of the filter
  Time stamp{};
  particles::ParticleFilter::State filter;
  std::vector<SensorState> sensors;
  monitoring::Standstill standstill;
  monitoring::HealthMonitor health;
  std::size_t events = 0;    ///< how many the host had noted
  std::size_t smoothed = 0;  ///< how many steps the smoother had
  Time last_stamp{};

  /// All but its place in the log, and the filter. Reading throws DataError if the checkpoint is of another
  /// configuration.
  template <class Archive>
  void serialize(Archive& archive) {
    if (archive.section("committed", 4) < 4) throw DataError("the checkpoint is of an older kind");
    auto count = static_cast<std::uint64_t>(sensors.size());
    archive(count);
    if (count != sensors.size())
      throw DataError(fmt::format("the checkpoint has {} sensors, the configuration {}", count, sensors.size()));
    for (SensorState& state : sensors) archive(state);
    archive(standstill, health, events, smoothed, last_stamp);
  }
};

/// All that a committed measurement changes: particles, sensors, monitors, the smoother's steps, events.
struct Committed {
  particles::ParticleFilter filter;
  std::vector<SensorRecord> sensors;
  monitoring::Standstill standstill;
  monitoring::HealthMonitor health;
  estimation::Smoother smoother;
  std::vector<Event> events = {};
  Time last_stamp{};

  SensorRecord& record(const Measurement& m) { return sensors[m.sensor]; }
  const SensorRecord& record(const Measurement& m) const { return sensors[m.sensor]; }

  void note(Time stamp, std::string text);
  void note_failure(Time stamp, std::string_view name, std::string_view why);
  void take_out_of_service(const Measurement& m, std::string_view why);
  /// Counts what became of a measurement.
  void count(const Measurement& m, Fate fate);
  /// Judges the health of sensors and pose at `now`.
  void judge_health(Time now);

  /// `at`: the number of the measurement that comes next.
  Mark mark(std::uint64_t at) const;
  /// The same for a checkpoint, which has the particles beside it.
  Mark mark_without_filter() const;
  void roll_back(const Mark& mark);
  /// Takes over everything but the filter and the events, out of a checkpoint.
  void take(Mark&& mark);
};

}  // namespace waymark::fusion
