// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>

#include "waymark/interface/snapshot.hpp"

namespace waymark::command {

/// A line on stderr while a run lasts: share of the log, its time, speed against real time, effective sample size,
/// landmarks. On a terminal one line that is rewritten; elsewhere a line for every tenth of the log.
class Progress {
 public:
  Progress();
  /// `share` of the log that was read, negative if unknown.
  void update(const Snapshot& snapshot, double share);
  void finish();
  double log_seconds() const { return log_seconds_; }
  double wall_seconds() const;

 private:
  using Clock = std::chrono::steady_clock;  // for the user; a filter never sees it

  bool terminal_;
  Clock::time_point start_ = Clock::now();
  Clock::time_point last_shown_ = start_;
  Clock::time_point next_landmarks_ = start_;
  std::string landmarks_;
  bool first_ = true;
  Time first_stamp_{};
  double log_seconds_ = 0.0;
  int tenths_shown_ = 0;
  bool line_open_ = false;
};

}  // namespace waymark::command
