// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "waymark/base/api.hpp"
#include "waymark/host/front.hpp"
#include "waymark/host/fusion_settings.hpp"
#include "waymark/interface/snapshot.hpp"

namespace waymark {

namespace fusion {
struct Inspection;
}

/// A pose given by a person or another program, in the frame of the results, and its σ.
struct GivenPose {
  Eigen::Vector2d position{0.0, 0.0};
  double yaw = 0.0;             ///< [rad]
  double position_sigma = 0.5;  ///< [m], of x and of y
  double yaw_sigma = 0.26;      ///< [rad]
};

/// The host of Fig. 2.1 of the paper. Every committed measurement predicts, updates and maps. The observer then
/// receives a snapshot.
///
///     Source → MeasurementQueue → Sensor ─→ EKF (one per particle) ─→ RBPF → Snapshot → Sinks
///                                       └→ MapModule::extract ─────────┘
class WAYMARK_API Fusion {
 public:
  /// Called after every processed or rejected measurement (`Snapshot::fate`). The snapshot is valid during the call.
  using Observer = std::function<void(const Snapshot&)>;

  /// Throws ConfigError if the parts do not fit together: no motion source, spatial motion without a sensor of roll and
  /// pitch, too many block states.
  Fusion(const FusionSettings& settings, std::vector<SensorSlot> sensors, std::vector<MapSlot> maps, Observer observer);
  ~Fusion();
  Fusion(const Fusion&) = delete;
  Fusion& operator=(const Fusion&) = delete;

  /// Adds one measurement, in order of arrival, and commits all that are due. `Measurement::sensor` is an index into
  /// the sensors.
  void add(Measurement measurement);
  /// Commits all buffered measurements, at the end of the log.
  void finish();

  /// Writes the committed state. Measurements are not included: `resume` reads them from the log again.
  void save(OutArchive& out) const;
  /// Returns the next measurement of the log, as passed to `add`; nothing at its end.
  using Next = std::function<std::optional<Measurement>()>;
  /// Continues from `save`, in a host without measurements. Reads as many measurements from `next` as had been added,
  /// without computing them again. All further results are byte-identical to those of one run. Throws DataError if
  /// checkpoint, configuration and log do not match.
  void resume(InArchive& in, const Next& next);

  /// As `save` and `resume`, for a running robot, whose measurements cannot be read again: those that are buffered, or
  /// needed for late ones, are part of it, and so are `waiting`, which have not been added yet; `resume_with_…` returns
  /// these. Throws Error if the filter has no pose.
  void save_with_measurements(OutArchive& out, std::span<const Measurement> waiting = {}) const;
  std::vector<Measurement> resume_with_measurements(InArchive& in);

  /// True once the start pose and the first motion measurement are known.
  bool started() const;
  /// True if the filter has started and its pose is not lost.
  bool has_pose() const;
  /// Calls `observer` with the last snapshot; not called if there was none.
  void visit_last(const Observer& observer) const;
  /// The belief at `at`, any time from the committed one on: the mixture's moments, updated with the buffered
  /// measurements and predicted to `at`. Changes neither particles nor maps. Throws Error if the filter has not
  /// started, or if `at` is before the committed time.
  Belief front(Time at) const;
  /// The same for another thread: the committed belief, to which the measurements from then on are added; null if the
  /// filter has not started.
  std::unique_ptr<Front> front() const;

  /// Changes what becomes of a sensor's measurements from the next processed one on. A mode is part of the checkpoint.
  void set_mode(std::uint32_t sensor, SensorMode mode);
  SensorMode mode(std::uint32_t sensor) const;
  /// Switches a map, by its index, on or off from the next processed measurement on. What is off takes no measurements
  /// and stays as it is. Part of the checkpoint. Throws Error if the map is out of service.
  void set_map_enabled(std::size_t map, bool enabled);
  bool map_enabled(std::size_t map) const;
  /// Notes that measurements of a sensor were dropped before `add`, since the filter does not keep up: the sensor's
  /// health is degraded for the next two seconds.
  void note_dropped(std::uint32_t sensor);
  /// Notes that measurements of a sensor did not arrive: its health is degraded for the next two seconds.
  void note_missing(std::uint32_t sensor);
  /// Begins position, heading and twist anew at a given pose, at the committed time; height, maps and the sensors' own
  /// states stay. Before the start it is the start pose, in place of that of the settings or the sensors. Throws Error
  /// beyond 1e8 m, or a σ of 1e-6 to 1e7 m, or to π rad.
  void set_pose(const GivenPose& pose);
  /// Number of measurements that were added, those before a checkpoint included.
  std::uint64_t arrived() const;
  /// The events of the filter since the last call, or since the checkpoint, as soon as they happen: `report` has all,
  /// in the order of their stamps. What a late measurement only repeats does not come again.
  std::vector<Event> take_new_events();
  /// Counters of the sensors and events so far; without the source's bad records.
  RunReport report() const;
  /// Health of sensors and pose after the last processed measurement.
  const Health& health() const;
  /// Indices of the error states, and the owners of the blocks; valid as long as the host.
  const StateLayout& layout() const;
  /// Number of error states of the georeference; 0 if the map's place on the Earth is not estimated.
  int georeference_states() const;
  /// The map's origin on the Earth; nothing while unknown.
  std::optional<Datum> datum() const;

 private:
  friend struct fusion::Inspection;
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace waymark
