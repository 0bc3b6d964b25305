// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "monitoring/settled_state.hpp"
#include "relocation/placement.hpp"
#include "waymark/base/api.hpp"
#include "waymark/base/error.hpp"
#include "waymark/host/fusion_settings.hpp"
#include "waymark/interface/health.hpp"
#include "waymark/interface/snapshot.hpp"
#include "waymark/io/archive.hpp"

namespace waymark::monitoring {

/// Result of one measurement, for its sensor's health.
struct UpdateResult {
  Fate fate = Fate::fused;
  double nis = 0.0;                       ///< summed over its updates
  int dof = 0;                            ///< rows of its updates; 0: none
  std::string_view degraded_reason = {};  ///< of the sensor's own monitoring; empty: none
  /// Whether maps that localise gave information about the pose; nothing if none used the measurement.
  std::optional<bool> localized = {};
  bool match_failed = false;        ///< the measurement did not fit the maps that localise
  bool match_searched = false;      ///< it contradicts them where they expected it, even after a search
  std::size_t suspected_tears = 0;  ///< in the maps, up to now: scans written at poses that may be wrong
  bool observes_position = false;   ///< an update observed the position
  /// The twist before was forgotten, so that the innovations are zero by construction: their NIS is none.
  bool nis_is_trivial = false;
  bool is_continuous = false;  ///< the sensor states that it follows its last accepted measurements
};

using relocation::Placement;

/// Assesses sensors and pose by the results of their measurements (docs/math/time.md: NIS, gate rates), in stamp order.
/// Its clock stands while nothing at all is measured, so that a pause of the log is no silence of a sensor. Copyable:
/// it is rolled back with the filter.
class WAYMARK_API HealthMonitor {
 public:
  /// Properties of a sensor, known at load.
  struct Role {
    std::string_view name;  ///< must outlive the monitor
    bool is_motion_source = false;
    bool is_aiding = false;      ///< absolute, or the trigger of a map that localises
    bool localizes = false;      ///< the trigger of a map that localises
    bool has_prior_map = false;  ///< the trigger of a map that localises and was loaded
    bool fused = true;
  };
  HealthMonitor(const HealthSettings& settings, const std::vector<Role>& roles, bool motion_from_maps);

  /// The filter starts.
  void start(Time stamp);
  /// The pose is lost and searched for, until `begin_anew`.
  void search();
  /// The pose was found anew, or taken from before with a wide covariance.
  void begin_anew(Time stamp);
  /// Adds the result of a measurement.
  void record(std::size_t sensor, Time stamp, const UpdateResult& result);
  /// The sensor's plugin is out of service.
  void out_of_service(std::size_t sensor) { sensors_[sensor].broken = true; }
  /// Adds a measurement with an implausible stamp.
  void mistimed(std::size_t sensor);
  /// The filter did not keep up, and measurements were dropped before it; `stamp`: of the filter.
  void dropped(std::size_t sensor, Time stamp);
  /// Measurements did not arrive; `stamp`: of the filter.
  void missing(std::size_t sensor, Time stamp);
  /// How what the robot sees fits the loaded map, from now on.
  void place(Placement placement) { placement_ = placement; }
  /// How many separate places and headings the particles have the robot at, from now on.
  void set_modes(std::size_t modes) { modes_ = modes; }
  /// Whether the covariance is that of the particles alone, which forget how uncertain their common past was.
  void set_particles_alone(bool are_alone) { particles_alone_ = are_alone; }
  /// True if most of its scans do not localise the robot in the loaded map.
  bool is_not_localized(std::size_t sensor) const { return is_not_localized(sensors_[sensor]); }
  /// The covariance was inflated to re-acquire a sensor.
  void reacquired(Time stamp) {
    advance(stamp);
    reacquired_ = clock_;
  }

  /// σ of a pose.
  struct Uncertainty {
    double position = 0.0;  ///< in the plane, the larger axis [m]
    double height = 0.0;    ///< [m]; 0 with planar motion
    double tilt = 0.0;      ///< of roll and pitch, the larger [rad]; 0 with planar motion
  };
  /// Updates the states of sensors and pose at `now`.
  void judge(Time now, const Uncertainty& sigma);
  const Health& health() const { return health_; }
  const HealthTimes& times() const { return times_; }

  /// Reading throws DataError if the checkpoint has an older version.
  template <class Archive>
  void serialize(Archive& archive) {
    if (archive.section("health", 9) < 9) throw DataError("the checkpoint has an older version");
    archive(clock_, newest_, step_, judged_, started_, reacquired_, began_anew_);
    serialize_state(archive, placement_, Placement::ambiguous);
    archive(times_.ok_s, times_.degraded_s, times_.lost_s);
    for (Track& track : sensors_) archive(track);
    serialize_state(archive, health_.state, Health::State::lost);
    archive(health_.reason, settled_);
    for (std::size_t i = 0; i < sensors_.size(); ++i) {
      serialize_state(archive, health_.sensors[i].state, SensorHealth::State::silent);
      archive(health_.sensors[i].reason);
    }
  }

 private:
  struct Track {
    Role role;
    bool broken = false;
    std::optional<Time> last;       // measurement, by the monitor's clock
    std::optional<Time> last_good;  // the last one that was accepted
    double interval = 0.0;          // running mean [s]
    double count = 0.0;             // of measurements, up to the window
    double gated = 0.0;             // running shares
    double unusable = 0.0;
    bool localized = true;  // in the last step of its maps; true until the first information, without a prior map
    bool was_localized = false;
    bool observes_position = false;     // some update did
    double steps = 0.0;                 // of its maps, up to the window
    double not_localized = 0.0;         // running share of those without information
    double not_matched = 0.0;           // the same of those that did not fit the map
    double contradicted = 0.0;          // the same of those that failed and contradict the map
    double searched = 0.0;              // the same of those that did not fit it where they were expected
    std::uint64_t suspected_tears = 0;  // in a map of this run
    double nis_ratio = 1.0;             // running mean of NIS over its degrees of freedom, gated ones clamped
    std::string degraded_reason;        // last report of the sensor's own monitoring
    std::optional<Time> degraded_at;
    SettledState<SensorHealth::State> settled;

    template <class Archive>
    void serialize(Archive& archive) {
      archive(broken, last, last_good, interval, count, gated, unusable, nis_ratio, degraded_reason, degraded_at,
              localized, was_localized, observes_position, steps, not_localized, not_matched, contradicted, searched,
              suspected_tears, settled);
    }
  };
  /// A verdict on a sensor or on the pose.
  template <class State>
  struct Verdict {
    State state = State::ok;
    std::string_view why = {};
    bool is_certain = false;  // counts at once
  };
  template <class Archive, class State>
  static void serialize_state(Archive& archive, State& state, State last) {
    int number = static_cast<int>(state);
    archive.within(number, 0, static_cast<int>(last));
    state = static_cast<State>(number);
  }
  static bool is_not_localized(const Track& track);
  void advance(Time now);
  void degrade(std::size_t sensor, Time stamp, std::string_view why);
  void add(Track& track, const UpdateResult& result);
  void count_time();
  Verdict<SensorHealth::State> judge_sensor(const Track& track) const;
  Verdict<Health::State> judge_pose(const Uncertainty& sigma, fmt::memory_buffer& text);
  bool is_position_observed() const;
  double off_probability() const;

  HealthSettings settings_;
  bool motion_from_maps_;
  std::vector<Track> sensors_;
  Time clock_{};                // its own time, in which something was measured
  std::optional<Time> newest_;  // stamp up to which the clock has advanced
  double step_ = 0.0;           // running mean of its steps [s]
  Time judged_{};               // up to here the times are counted
  std::optional<Time> started_;
  std::optional<Time> reacquired_;
  std::optional<Time> began_anew_;  // the filter, after its pose was lost
  bool searching_ = false;          // the pose is lost; not on a checkpoint, which repeats a search
  Placement placement_ = Placement::fits;
  std::size_t modes_ = 1;         // not on a checkpoint: set before each judgement
  bool particles_alone_ = false;  // likewise
  Health health_;
  SettledState<Health::State> settled_;
  HealthTimes times_;
};

}  // namespace waymark::monitoring
