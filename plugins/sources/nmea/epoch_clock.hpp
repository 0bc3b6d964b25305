// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <optional>

#include "epoch.hpp"
#include "waymark/io/bad_record_list.hpp"

namespace waymark::nmea {

/// Gives epochs their date and judges whether their time can be right. A receiver counts from some start-up time until
/// satellites give it the true one, so nothing before the first fix has a stamp.
class EpochClock {
 public:
  /// `start_date`: of the first epoch, if no sentence has it. A larger step forward than `max_jump` is a fault.
  EpochClock(std::optional<std::chrono::sys_days> start_date, Duration max_jump)
      : date_(start_date), max_jump_(max_jump) {}

  /// The stamp (UTC), or nothing if there is none to be trusted; faults go to `bad`. Throws DataError if that is full.
  std::optional<Time> stamp(const Epoch& epoch, BadRecordList& bad);

 private:
  std::optional<std::chrono::sys_days> date_;  // of the last epoch
  std::optional<Duration> time_of_day_;        // of the last epoch
  Duration max_jump_;
  std::optional<Time> newest_;
  bool had_fix_ = false;
};

}  // namespace waymark::nmea
