// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

#include "fusion/committed.hpp"
#include "fusion/horizon.hpp"
#include "waymark/host/fusion_settings.hpp"

namespace waymark::fusion {

/// Steps common to the present and the past horizon: sensors, maps, counters, events, health.
class CommittedSteps {
 public:
  /// All must outlive the object.
  CommittedSteps(Committed& committed, MapExtraction& maps, std::optional<Datum>& datum, bool has_motion_sensor)
      : committed_(committed), maps_(maps), datum_(datum), has_motion_sensor_(has_motion_sensor) {}

  Committed& committed() { return committed_; }
  MapExtraction& maps() { return maps_; }

  /// The sensor's start hint; nothing if it has none, or if its plugin rejects the measurement. The first proposed
  /// datum is stored. A plugin that throws anything but DataError is taken out of service.
  std::optional<StartHint> start_hint(const Measurement& m);
  /// The map's origin on the Earth, which this measurement may define; null while unknown.
  const Datum* datum(const Measurement& m);
  /// Counts update `index` of a measurement and reports its outcome to the sensor. False if the update was not finite;
  /// nothing was applied then.
  bool account(const Measurement& m, std::size_t index, const particles::MixtureOutcome& outcome, UpdateResult& result);
  /// The observations of the map modules that this measurement triggers. `belief`: the mixture, for the motion window.
  Extraction extract(const Measurement& m, const Belief& belief);
  /// One mapping step of the particles at `at`. Modules that throw are taken out of service.
  void map(const Measurement& m, particles::Instant& at, const Extraction& extraction, UpdateResult& result);
  /// Adds an event if the robot is misplaced in a loaded map, or is not any more.
  void note_misplaced(const Measurement& m, bool was_misplaced);
  /// Adds an event for the first unusable measurement of a sensor.
  void note_unusable(const Measurement& m, std::string_view why);
  /// Completes a measurement: stores it for maps with several inputs, records its result for the health, and adds
  /// events. May change `result.fate` from ignored to paired.
  void conclude(const Measurement& m, UpdateResult& result);

 private:
  bool velocity_is_measured() const;
  MotionWindow window_of(const Belief& belief) const;

  Committed& committed_;
  MapExtraction& maps_;
  std::optional<Datum>& datum_;
  bool has_motion_sensor_;
};

}  // namespace waymark::fusion
