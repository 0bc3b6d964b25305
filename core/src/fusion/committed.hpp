// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "estimation/smoother.hpp"
#include "fusion/new_events.hpp"
#include "fusion/sensor_record.hpp"
#include "monitoring/health_monitor.hpp"
#include "monitoring/standstill.hpp"
#include "particles/particle_filter.hpp"
#include "waymark/base/error.hpp"
#include "waymark/interface/pose_modes.hpp"

namespace waymark::fusion {

/// σ of roll and pitch [rad], the larger one; 0 with planar motion.
double tilt_sigma(const Belief& belief, const StateLayout& layout);

/// The committed state before one measurement, restored by a rollback.
struct Mark {
  std::uint64_t at = 0;  ///< number of that measurement since the start of the filter
  Time stamp{};
  particles::ParticleFilter::State filter;
  std::vector<SensorState> sensors;
  monitoring::Standstill standstill;
  monitoring::HealthMonitor health;
  std::size_t events = 0;    ///< number of events
  std::size_t smoothed = 0;  ///< number of steps of the smoother
  Time last_stamp{};

  /// All but `at`, `stamp` and the filter. Reading throws DataError if the checkpoint is of another configuration.
  template <class Archive>
  void serialize(Archive& archive) {
    if (archive.section("committed", 6) < 6) throw DataError("the checkpoint has an older version");
    auto count = static_cast<std::uint64_t>(sensors.size());
    archive(count);
    if (count != sensors.size())
      throw DataError(fmt::format("the checkpoint has {} sensors, the configuration {}", count, sensors.size()));
    for (SensorState& state : sensors) archive(state);
    archive(standstill, health, events, smoothed, last_stamp);
  }
};

/// The committed state: all that a committed measurement changes.
struct Committed {
  particles::ParticleFilter filter;
  std::vector<SensorRecord> sensors;  ///< in the order of the rig
  monitoring::Standstill standstill;
  monitoring::HealthMonitor health;
  estimation::Smoother smoother;
  std::vector<Event> events = {};
  NewEvents new_events = {};  ///< of `events`
  Time last_stamp{};          ///< of the last measurement, buffered ones before the start included
  ModeFinder modes = {};
  std::vector<ParticleView> views = {};  ///< scratch of `update_health`
  bool unsound = false;                  ///< no belief can be updated any more: its numbers have no meaning

  /// The sensor of a measurement.
  SensorRecord& record(const Measurement& m) { return sensors[m.sensor]; }
  const SensorRecord& record(const Measurement& m) const { return sensors[m.sensor]; }

  /// Adds an event.
  void note(Time stamp, std::string text);
  /// Adds the event that a loop has moved the maps, if one has.
  void note_closed_loop(Time stamp);
  /// Adds the event that the plugin of `name`, a sensor or map, is taken out of service.
  void note_failure(Time stamp, std::string_view name, std::string_view why);
  /// Drops the plugin of the measurement's sensor and adds the event.
  void take_out_of_service(const Measurement& m, std::string_view why);
  /// Counts the result of a measurement.
  void count(const Measurement& m, Fate fate);
  /// Updates the health of sensors and pose at `now`.
  void update_health(Time now);
  /// At how many separate places and headings the particles have the robot. The mixture must be current.
  std::size_t count_modes();

  /// The present state. `at`: number of the next measurement.
  Mark mark(std::uint64_t at) const;
  /// The same for a checkpoint, which has the particles beside it.
  Mark mark_without_filter() const;
  void roll_back(const Mark& mark);
  /// Moves in the state of a checkpoint, except for the filter and the events.
  void take(Mark&& mark);
};

}  // namespace waymark::fusion
