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
  /// What becomes of a clock that was set back: a log must stay in order; a running robot needs its receiver.
  enum class StepBack { is_left_out, is_believed_the_second_time };

  /// `start_date`: of the first epoch, if no sentence has it. A larger step forward than `max_jump` is a fault.
  EpochClock(std::optional<std::chrono::sys_days> start_date, Duration max_jump, StepBack step_back)
      : date_(start_date), max_jump_(max_jump), step_back_(step_back) {}

  /// The stamp (UTC), or nothing if there is none to be trusted; faults go to `bad`. Throws DataError if that is full.
  std::optional<Time> stamp(const Epoch& epoch, BadRecordList& bad);

 private:
  bool goes_on_after_step_back(Time stamp);

  std::optional<std::chrono::sys_days> date_;  // of the last epoch
  std::optional<Duration> time_of_day_;        // of the last epoch
  Duration max_jump_;
  StepBack step_back_;
  std::optional<Time> newest_;
  std::optional<Time> stepped_back_to_;  // by the last epoch
  bool had_fix_ = false;
};

}  // namespace waymark::nmea
