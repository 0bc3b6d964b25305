// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <vector>

#include "waymark/base/time.hpp"
#include "waymark/io/archive.hpp"

namespace waymark::monitoring {

/// The robot stands when all motion sensors that are alive have seen no motion for a while, and none fell silent while
/// it saw some (docs/math/ekf.md).
class Standstill {
 public:
  Standstill(std::size_t sensors, Duration after) : reports_(sensors), after_(after) {}

  /// `until_next`: the report holds until the sensor's next one, however long that takes.
  void report(std::size_t sensor, Time stamp, bool moving, bool until_next = false) {
    Report& report = reports_[sensor];
    if (!report.any || moving) report.still_since = stamp;
    report.any = true;
    report.last = stamp;
    report.moving = moving;
    report.until_next = until_next;
    standing_ = std::all_of(reports_.begin(), reports_.end(), [&](const Report& r) {
      // The last report of a silent sensor stays: wheels that died while they turned did not stop the robot.
      const bool alive = r.any && stamp - r.last < kSilence;
      return !r.any || (!r.moving && (!alive || stamp - r.still_since >= after_));
    });
  }

  bool standing() const { return standing_; }

  /// Ends a standstill that no motion sensor reports any more; true if this ended it.
  bool lapses(Time now) {
    if (!standing_ || std::any_of(reports_.begin(), reports_.end(), [&](const Report& r) {
          return r.any && (r.until_next || now - r.last < kSilence);
        })) {
      return false;
    }
    standing_ = false;
    return true;
  }

  template <class Archive>
  void serialize(Archive& archive) {
    for (Report& report : reports_)
      archive(report.any, report.moving, report.until_next, report.last, report.still_since);
    archive(standing_);
  }

 private:
  struct Report {
    bool any = false;
    bool moving = true;
    bool until_next = false;
    Time last{};
    Time still_since{};
  };
  static constexpr Duration kSilence = std::chrono::seconds(1);

  std::vector<Report> reports_;
  Duration after_;
  bool standing_ = false;
};

}  // namespace waymark::monitoring
