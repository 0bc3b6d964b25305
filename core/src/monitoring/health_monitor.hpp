// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "waymark/base/error.hpp"
#include "waymark/host/fusion_settings.hpp"
#include "waymark/interface/health.hpp"
#include "waymark/interface/snapshot.hpp"
#include "waymark/io/archive.hpp"

namespace waymark::monitoring {

/// What one measurement did, for its sensor's health.
struct UpdateResult {
  Fate fate = Fate::fused;
  double nis = 0.0;  ///< summed over its updates
  int dof = 0;       ///< rows of its updates; 0: none
  std::string_view doubt = {};
  /// Whether the maps that localise by it gave information about the pose; nothing if they were not asked.
  std::optional<bool> located = {};
};

/// Judges sensors and the whole from what becomes of their measurements (docs/math/time.md: NIS, gate rates), in stamp
/// order. Copyable: it is rolled back with the filter.
class HealthMonitor {
 public:
  /// What is known of a sensor at load.
  struct Role {
    std::string_view name;  ///< must outlive the monitor
    bool is_motion_source = false;
    bool ties_to_map = false;    ///< absolute, or the trigger of a map that localises
    bool has_prior_map = false;  ///< the trigger of a map that localises and was loaded
    bool fused = true;
  };
  HealthMonitor(const HealthSettings& settings, const std::vector<Role>& roles, bool motion_from_maps);

  void start(Time stamp) { started_ = stamp; }
  void record(std::size_t sensor, Time stamp, const UpdateResult& what);
  void out_of_service(std::size_t sensor) { sensors_[sensor].broken = true; }
  void mistimed(std::size_t sensor, Time stamp);
  /// True if most of its scans do not localise the robot in the loaded map.
  bool is_not_localized(std::size_t sensor) const { return is_not_localized(sensors_[sensor]); }
  /// The belief was widened: what came before cannot be trusted.
  void reacquired(Time stamp) { reacquired_ = stamp; }

  /// Settles the state of all at `now`. `position_sigma`: of the pose, the larger axis [m].
  void judge(Time now, double position_sigma);
  const Health& health() const { return health_; }

  /// Reading throws DataError if the checkpoint is of an older kind.
  template <class Archive>
  void serialize(Archive& archive) {
    if (archive.section("health", 3) < 3) throw DataError("the checkpoint is of an older kind");
    archive(started_, reacquired_);
    for (Track& track : sensors_) archive(track);
  }

 private:
  struct Track {
    Role role;
    bool broken = false;
    std::optional<Time> last;       // stamp of the last measurement
    std::optional<Time> last_good;  // of the last one that was accepted
    double interval = 0.0;          // running mean [s]
    double count = 0.0;             // of measurements, up to the window
    double gated = 0.0;             // running shares
    double unusable = 0.0;
    bool located = true;  // by the last step of its maps; before the first that was, a map could give none
    bool was_located = false;
    double steps = 0.0;          // of its maps, up to the window
    double not_localized = 0.0;  // running share of those that gave none
    double nis_ratio = 1.0;      // running mean of NIS over its degrees of freedom, gated ones clamped
    std::string doubt;
    std::optional<Time> doubted;

    template <class Archive>
    void serialize(Archive& archive) {
      archive(broken, last, last_good, interval, count, gated, unusable, nis_ratio, doubt, doubted, located,
              was_located, steps, not_localized);
    }
  };
  static bool is_not_localized(const Track& track);
  void judge_sensor(const Track& track, Time now, SensorHealth& health) const;
  double off_probability() const;

  HealthSettings settings_;
  bool motion_from_maps_;
  std::vector<Track> sensors_;
  std::optional<Time> started_;
  std::optional<Time> reacquired_;
  Health health_;
};

}  // namespace waymark::monitoring
