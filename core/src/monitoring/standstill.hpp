// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <vector>

#include "waymark/base/time.hpp"
#include "waymark/io/archive.hpp"

namespace waymark::monitoring {

/// Detects standstill: all active motion sensors report no motion for a while, none became silent while it reported
/// motion, and one of them measures the velocity (docs/math/ekf.md): to an IMU alone, smooth straight driving is rest.
class Standstill {
 public:
  Standstill(std::size_t sensors, Duration after) : reports_(sensors), after_(after) {}

  /// A sensor's report of its motion.
  struct Reported {
    bool moving = true;
    bool measures_velocity = true;  ///< false: it measures how the robot turns, no more
    bool until_next = false;        ///< valid until the sensor's next one, without time limit
  };
  void report(std::size_t sensor, Time stamp, const Reported& reported) {
    Report& report = reports_[sensor];
    if (!report.any || reported.moving) report.still_since = stamp;
    report.any = true;
    report.last = stamp;
    report.moving = reported.moving;
    report.until_next = reported.until_next;
    report.measures_velocity = reported.measures_velocity;
    const bool velocity_is_zero = std::any_of(
        reports_.begin(), reports_.end(), [](const Report& r) { return r.any && !r.moving && r.measures_velocity; });
    standing_ = velocity_is_zero && std::all_of(reports_.begin(), reports_.end(), [&](const Report& r) {
                  // The last report of a silent sensor stays valid: wheels that fail while they turn do not stop the
                  // robot.
                  const bool alive = r.any && stamp - r.last < kSilence;
                  return !r.any || (!r.moving && (!alive || stamp - r.still_since >= after_));
                });
  }

  bool standing() const { return standing_; }

  /// True if the last report of a sensor is valid until its next one: the motion is known, however long it is silent.
  bool is_known_until_next() const {
    return std::any_of(reports_.begin(), reports_.end(), [](const Report& r) { return r.any && r.until_next; });
  }

  /// Ends the standstill if all motion sensors are silent; true if this ended it.
  bool lapses(Time now) {
    if (!standing_ || std::any_of(reports_.begin(), reports_.end(), [&](const Report& r) {
          return r.any && (r.until_next || now - r.last < kSilence);
        })) {
      return false;
    }
    standing_ = false;
    return true;
  }

  /// Nothing is known about the motion, as before the first report.
  void reset() {
    std::fill(reports_.begin(), reports_.end(), Report{});
    standing_ = false;
  }

  template <class Archive>
  void serialize(Archive& archive) {
    for (Report& report : reports_)
      archive(report.any, report.moving, report.until_next, report.measures_velocity, report.last, report.still_since);
    archive(standing_);
  }

 private:
  struct Report {
    bool any = false;
    bool moving = true;
    bool until_next = false;
    bool measures_velocity = false;
    Time last{};
    Time still_since{};
  };
  static constexpr Duration kSilence = std::chrono::seconds(1);

  std::vector<Report> reports_;
  Duration after_;
  bool standing_ = false;
};

}  // namespace waymark::monitoring
