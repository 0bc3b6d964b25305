// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "waymark/base/api.hpp"
#include "waymark/interface/finding.hpp"
#include "waymark/interface/health.hpp"
#include "waymark/interface/map_view.hpp"
#include "waymark/interface/measurement.hpp"
#include "waymark/interface/nav_state.hpp"
#include "waymark/interface/sensor.hpp"
#include "waymark/interface/source.hpp"

namespace waymark {

/// Pose and weight of a particle, for pictures.
struct ParticleView {
  Pose T_map_base;
  double weight;  ///< normalised
};

/// A pose of a path.
struct StampedPose {
  Time stamp;
  Pose T_map_base;
};

/// A pose estimated from the whole log, with the covariance of (x, y, yaw).
struct SmoothedPose {
  Time stamp;
  Pose T_map_base;
  Eigen::Matrix3d P = Eigen::Matrix3d::Zero();
};

/// Result of one measurement.
enum class Fate {
  fused,         ///< all its updates were accepted
  gated,         ///< at least one update was rejected by the gate
  mapped,        ///< a map module used it
  skipped,       ///< no map module used it: too little motion, or no detection
  held_out,      ///< the YAML keeps it out of the filter, for scoring
  late,          ///< older than the stored history
  before_start,  ///< the filter had not started
  unusable,      ///< rejected by the plugin, or an update was not finite
  ignored,       ///< no plugin in service takes it
  paired,        ///< stored for a map module, which uses it with a measurement of its first input
  mistimed       ///< implausible stamp: zero, in the future, stuck, or far from all others
};
constexpr Fate last_of(Fate /*fate*/) { return Fate::mistimed; }

/// Detail of the maps that a sink requests.
enum class MapDetail {
  summary,       ///< landmarks, figures, sightings: cheap
  with_grids,    ///< dense maps seen from above, too
  with_files,    ///< the maps' files, too; without grids
  with_mixtures  ///< with grids, and with their mixture over all particles; costs a grid of each particle
};

struct SensorCounters;

/// The belief after one measurement, read-only, valid during `Sink::write`. Expensive views are made on request.
class WAYMARK_TYPE Snapshot {
 public:
  virtual ~Snapshot() = default;
  /// Time of `belief`. Later than the measurement's own stamp if that was late.
  virtual Time stamp() const = 0;
  virtual const Measurement& measurement() const = 0;  ///< the measurement behind this snapshot
  virtual Fate fate() const = 0;
  /// Of the measurement's sensor, this measurement included. The reference is valid during the call.
  virtual const SensorCounters& counters() const = 0;
  /// True once the filter has started, and not while its pose is lost; otherwise only `measurement`, `fate` and
  /// `health` are valid.
  virtual bool started() const = 0;
  /// Moments of the mixture (circular mean for yaw) at `stamp`.
  virtual const Belief& belief() const = 0;
  virtual const StateLayout& layout() const = 0;
  /// The map's origin on the Earth; nothing while unknown.
  virtual std::optional<Datum> datum() const = 0;
  virtual double effective_sample_size() const = 0;
  virtual const Health& health() const = 0;
  virtual std::vector<ParticleView> particles() const = 0;
  /// The whole path of the particle with the highest weight.
  virtual std::vector<StampedPose> best_path() const = 0;
  /// The maps of the particle with the highest weight.
  virtual std::vector<MapDescription> best_maps(MapDetail detail) const = 0;
  /// Number of mapping steps so far, those before a checkpoint included.
  virtual std::uint64_t mapping_steps() const = 0;
};

/// Numbers of one sensor's measurements by `Fate`, and its NIS.
struct SensorCounters {
  std::uint64_t fused = 0;
  std::uint64_t gated = 0;
  std::uint64_t mapped = 0;
  std::uint64_t skipped = 0;
  std::uint64_t held_out = 0;
  std::uint64_t late = 0;
  std::uint64_t before_start = 0;
  std::uint64_t unusable = 0;
  std::uint64_t ignored = 0;
  std::uint64_t processed_late = 0;  ///< older than the committed time, and processed
  double nis_sum = 0.0;              ///< of accepted and gated updates, and of the poses that maps determine
  std::uint64_t nis_count = 0;
  std::uint64_t nis_dof = 0;  ///< sum of their rows: mean NIS should be near nis_dof / nis_count

  template <class Archive>
  void serialize(Archive& archive) {
    archive(fused, gated, mapped, skipped, held_out, late, before_start, unusable, ignored, processed_late, nis_sum,
            nis_count, nis_dof);
  }
};

/// Report of one sensor over a run.
struct SensorReport : SensorCounters {
  std::string name;
  std::string plugin;
  bool is_motion_source = false;
  std::uint64_t measurements = 0;  ///< arrived
  std::uint64_t mistimed = 0;
  std::uint64_t reordered = 0;  ///< stamped before an earlier arrival of the same sensor
  Time first{};                 ///< stamp of the first and last measurement
  Time last{};
  double latency_mean_s = 0.0;  ///< arrival minus stamp
  double latency_max_s = 0.0;
  double gap_max_s = 0.0;  ///< longest time between the stamps of two successive arrivals
};

/// An event for the user, with its time in the log.
struct Event {
  std::string text;
  Time stamp{};
  bool is_failure = false;  ///< a plugin was taken out of service, or the pose was lost to the end

  template <class Archive>
  void serialize(Archive& archive) {
    archive(text, stamp, is_failure);
  }
};

/// Median, 99 % quantile and maximum of a latency [s].
struct LatencyReport {
  double median = 0.0;
  double p99 = 0.0;
  double max = 0.0;
};

/// Report of a running robot, beside what a log's run has.
struct LiveReport {
  /// What arrived for one sensor.
  struct Stream {
    std::string sensor;
    std::uint64_t received = 0;
    std::uint64_t dropped = 0;    ///< not passed to the filter, which could not keep up
    std::uint64_t missing = 0;    ///< did not arrive, by the gaps in the stamps of a sensor with a steady period
    std::uint64_t waits = 0;      ///< times at which the source had to wait for room in the queue
    double clock_offset_s = 0.0;  ///< stamp minus arrival of the quickest measurement of the last 10 s
    double clock_drift = 0.0;     ///< by which the sensor's clock is fast [s/s]
    LatencyReport latency_s;      ///< from arrival to the filter's pose
  };
  std::vector<Stream> streams;
  LatencyReport front_latency_s;  ///< from a motion measurement's arrival to the pose now that contains it
  double cpu_share = 0.0;         ///< of one core, all threads
  double duration_s = 0.0;
};

/// How the scans of a map that matches them fared: of the particle with the highest weight and its ancestors.
struct MatchReport {
  std::string map;
  std::uint64_t matches = 0;
  std::uint64_t failed = 0;    ///< scans that did not fit the map
  std::uint64_t searches = 0;  ///< matches that needed a search around the predicted pose
};

/// Report of a run.
struct RunReport {
  std::vector<SensorReport> sensors;
  std::vector<BadRecord> bad_records;
  std::vector<std::string> notices;  ///< of the source
  std::vector<Event> events;         ///< plugins taken out of service, lock-outs, …
  HealthTimes health;
  std::vector<MatchReport> matches;  ///< of the maps that match scans
  std::vector<Finding> findings;     ///< of the diagnosis, in the order in which they became certain
  bool interrupted = false;
  std::uint64_t resamplings = 0;
  std::uint64_t mapping_steps = 0;
  std::optional<LiveReport> live;
  std::vector<SmoothedPose> smoothed;  ///< of a run without maps, if `filter.smooth` is set; one per step
};

}  // namespace waymark
