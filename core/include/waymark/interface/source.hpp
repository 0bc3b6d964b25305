// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "waymark/interface/measurement.hpp"
#include "waymark/math/pose.hpp"

namespace waymark {

/// A stream of one payload type that a source delivers to one sensor of the YAML.
struct Channel {
  std::string sensor;        ///< name in the YAML
  std::string payload_type;  ///< "waymark/LaserScan@1"
};

/// Ground truth, for pictures and scores: simulated truth, a survey, motion capture. Never used by a filter.
struct Reference {
  struct Point {
    Time stamp;
    Pose T_map_base;  ///< yaw is meaningful only if `has_yaw`
    bool has_yaw = false;
    bool is_planar = false;  ///< its height, roll and pitch are unknown, and 0
  };
  struct Landmark {
    std::string name;
    Eigen::Vector2d p_map;
    double radius_m = 0.0;  ///< NaN: unknown
  };
  std::vector<Point> trajectory;
  std::vector<Landmark> landmarks;
};

/// A row or record that a source skipped.
struct BadRecord {
  std::string place;   ///< "file:line"
  std::string reason;  ///< what was found and what was expected
};

/// Delivers measurements. The host pulls them, so a replay is deterministic and drops nothing. Constructed from the
/// YAML: `explicit MySource(const Config&)` or `MySource(const Config&, const Rig&)`.
///
/// A live source waits in `next` for what arrives. The host reads it in a thread of its own and sets `arrival`; the
/// stamp is in UTC, or `kUnknownStamp`. A lost connection is no end: the source restores it, and reports both in
/// `take_events`. `next` is called by one thread only; `stop` and `take_events` are called by others meanwhile.
class WAYMARK_TYPE Source {
 public:
  virtual ~Source() = default;

  /// The delivered channels; `Measurement::sensor` of `next()` is an index into this list.
  virtual const std::vector<Channel>& channels() const = 0;

  /// The next measurement in order of arrival, or nothing at the end. Throws DataError when the data cannot be read on.
  virtual std::optional<Measurement> next() = 0;

  /// True if `next` waits for measurements of a running robot.
  virtual bool is_live() const { return false; }
  /// Of a live source: `next` returns nothing within 0.1 s, now and from now on.
  virtual void stop() {}
  /// Of a live source: what happened since the last call, one line each: connected, lost, restored.
  virtual std::vector<std::string> take_events() { return {}; }
  /// Of a live source in simulated time: the time now, which is then that of arrivals; nothing: that of the computer.
  /// May be called by any thread.
  virtual std::optional<Time> simulated_time() const { return std::nullopt; }
  /// Where the robot itself says that a sensor is mounted (`base_T_sensor: from_tf`); waits for that. Nothing if this
  /// source does not learn it. Called before `next`. Throws DataError if it was not said in time.
  virtual std::optional<Pose> T_base_sensor(std::string_view /*sensor*/) { return std::nullopt; }

  /// Share of the log that was read, 0..1; negative if unknown (live).
  virtual double progress() const { return -1.0; }

  /// Records skipped so far.
  virtual const std::vector<BadRecord>& bad_records() const {
    static const std::vector<BadRecord> none;
    return none;
  }

  /// Messages about the log for users, once it was read: unused messages, repairs. One line each.
  virtual std::vector<std::string> notices() const { return {}; }

  /// Ground truth; null if the source has none. Throws DataError if it cannot be read; the measurements still can.
  virtual std::shared_ptr<const Reference> reference() const { return nullptr; }
};

}  // namespace waymark
