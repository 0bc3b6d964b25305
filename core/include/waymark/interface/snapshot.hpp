// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "waymark/base/api.hpp"
#include "waymark/interface/health.hpp"
#include "waymark/interface/map_module.hpp"
#include "waymark/interface/measurement.hpp"
#include "waymark/interface/nav_state.hpp"
#include "waymark/interface/source.hpp"

namespace waymark {

/// A particle for pictures.
struct ParticleView {
  Pose T_map_base;
  double weight;  ///< normalised
};

/// A pose of a path.
struct StampedPose {
  Time stamp;
  Pose T_map_base;
};

/// A pose that knows the whole log, with the covariance of (x, y, yaw).
struct SmoothedPose {
  Time stamp;
  Pose T_map_base;
  Eigen::Matrix3d P = Eigen::Matrix3d::Zero();
};

/// What became of one measurement.
enum class Fate {
  fused,         ///< all its updates were accepted
  gated,         ///< at least one update was rejected by the gate
  mapped,        ///< a map module took it
  skipped,       ///< a map module looked at it and has no use for it: the robot has hardly moved, nothing was seen
  held_out,      ///< the YAML keeps it out of the filter, for scoring
  late,          ///< older than what the filter still remembers
  before_start,  ///< the filter had not started
  unusable,      ///< the plugin could not read it, or it held no finite value
  ignored,       ///< no plugin in service takes it
  paired,        ///< kept for a map module, which takes it with a measurement of its first input
  mistimed       ///< its stamp cannot be right: zero, in the future, stuck, or far from all others
};

/// How much of the maps a sink asks for.
enum class MapDetail {
  summary,       ///< landmarks, figures, sightings: cheap
  with_grids,    ///< dense maps seen from above, too
  with_files,    ///< what the maps write as files, too; without grids
  with_mixtures  ///< with grids, and with what all particles together make of them; as long as a grid of each particle
};

/// The belief after one measurement, read-only, valid during `Sink::write`. Expensive views are made when asked for.
class WAYMARK_TYPE Snapshot {
 public:
  virtual ~Snapshot() = default;
  /// What `belief` speaks of. Later than the measurement's own stamp if that came late.
  virtual Time stamp() const = 0;
  virtual const Measurement& measurement() const = 0;  ///< the measurement behind this snapshot
  virtual Fate fate() const = 0;
  /// True once the filter has started; before that only `measurement` and `fate` have a meaning.
  virtual bool started() const = 0;
  /// Moments of the mixture (circular mean for yaw) at `stamp`.
  virtual const Belief& belief() const = 0;
  virtual const StateLayout& layout() const = 0;
  virtual double effective_sample_size() const = 0;
  virtual const Health& health() const = 0;
  virtual std::vector<ParticleView> particles() const = 0;
  /// The whole path of the particle with the highest weight.
  virtual std::vector<StampedPose> best_path() const = 0;
  /// The maps of the particle with the highest weight.
  virtual std::vector<MapDescription> best_maps(MapDetail detail) const = 0;
};

/// What became of one sensor's measurements.
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
  std::uint64_t processed_late = 0;  ///< older than the commit horizon, and processed all the same
  double nis_sum = 0.0;              ///< of accepted and gated updates
  std::uint64_t nis_count = 0;
  std::uint64_t nis_dof = 0;  ///< sum of the updates' rows: mean NIS should be near nis_dof / nis_count
};

/// One sensor over a run.
struct SensorReport : SensorCounters {
  std::string name;
  std::string plugin;
  std::uint64_t measurements = 0;  ///< arrived
  std::uint64_t mistimed = 0;
  std::uint64_t reordered = 0;  ///< stamped before another of the same sensor that came earlier
  double first_s = 0.0;         ///< stamp of the first and last measurement [s]
  double last_s = 0.0;
  double latency_mean_s = 0.0;  ///< arrival minus stamp
  double latency_max_s = 0.0;
  double gap_max_s = 0.0;  ///< longest time between stamps of two that arrived one after the other
};

/// Something that a user must know about, with its time in the log.
struct Event {
  std::string text;
  double stamp_s = 0.0;
  bool is_failure = false;  ///< a plugin was taken out of service

  template <class Archive>
  void serialize(Archive& archive) {
    archive(text, stamp_s, is_failure);
  }
};

/// What a run ends with.
struct RunReport {
  std::vector<SensorReport> sensors;
  std::vector<BadRecord> bad_records;
  std::vector<std::string> notices;  ///< of the source
  std::vector<Event> events;         ///< plugins taken out of service, lock-outs, …
  bool interrupted = false;
  std::uint64_t resamplings = 0;
  std::uint64_t mapping_steps = 0;
  std::vector<SmoothedPose> smoothed;  ///< of a run without maps, if `filter.smooth` is set; one per step
};

}  // namespace waymark
