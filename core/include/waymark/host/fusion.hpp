// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "waymark/base/api.hpp"
#include "waymark/host/fusion_settings.hpp"
#include "waymark/interface/snapshot.hpp"

namespace waymark {

namespace particles {
class ParticleFilter;
}

/// The host of Fig. 2.1 of the paper: measurements in, in any order of arrival; every committed one predicts, updates,
/// maps, and is shown as a snapshot.
///
///     Source → MeasurementQueue → Sensor ─→ EKF (one per particle) ─→ RBPF → Snapshot → Sinks
///                                       └→ MapModule::extract ─────────┘
class WAYMARK_API Fusion {
 public:
  /// Called after every committed measurement; the snapshot is valid during the call.
  using Observer = std::function<void(const Snapshot&)>;

  /// Throws ConfigError if the parts do not fit: no motion source, spatial motion without a source of roll and pitch,
  /// too many block states.
  Fusion(const FusionSettings& settings, std::vector<SensorSlot> sensors, std::vector<MapSlot> maps, Observer observer);
  ~Fusion();
  Fusion(const Fusion&) = delete;
  Fusion& operator=(const Fusion&) = delete;

  /// Takes one measurement; `sensor` is an index into the sensors. What is due is committed.
  void add(Measurement measurement);
  /// Commits everything that waits: the end of the log.
  void finish();

  /// The committed state, to go on from later. Measurements are not in it: `resume` reads them from the log again.
  void save(OutArchive& out) const;
  /// The next measurement of the log, as `add` was given it; nothing at its end.
  using Next = std::function<std::optional<Measurement>()>;
  /// Goes on where `save` was called, in a host that has been given nothing yet: takes from `next` as many measurements
  /// as had been added, without computing them again. From there on everything is the same to the byte as in one run.
  /// Throws DataError if checkpoint, configuration and log do not fit together.
  void resume(InArchive& in, const Next& next);

  bool started() const;
  /// Shows the last committed measurement again, to `observer` alone; not called if there was none.
  void show_last(const Observer& observer) const;
  /// The belief now, at any time at or after the committed one: the mixture's moments with what is not yet committed
  /// applied, predicted to `at`. Particles and maps are not touched. Throws Error if the filter has not started.
  Belief front(Time at) const;
  /// Sensor counters and events so far; bad records are the source's.
  RunReport report() const;
  const Health& health() const;
  const particles::ParticleFilter& filter() const;
  const StateLayout& layout() const;
  /// How many of the layout's states are the map's place on the Earth; 0 if that is not estimated.
  int georeference_states() const;
  /// The map's origin on the Earth, once known.
  std::optional<Datum> datum() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace waymark
