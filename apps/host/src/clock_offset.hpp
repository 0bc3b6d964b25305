// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <optional>

#include "waymark/base/time.hpp"

namespace waymark::host {

/// Offsets of a clock, stamp minus arrival, with which the filter takes its stamps.
struct UsableOffsets {
  Duration least = -kLongest;
  Duration most = kLongest;
  bool contains(Duration offset) const { return offset >= least && offset <= most; }
};

/// Offset and drift of a sensor's clock against that of the arrivals, by the minimum-delay filter (Cristian, 1989: the
/// exchange with the least delay bounds the offset best). The least delay of each window lies on the line of the
/// clocks; the delay common to all measurements remains in the offset.
class ClockOffset {
 public:
  void add(Time stamp, Time arrival);

  /// Stamp minus arrival of the quickest measurement of the last window, negative for a delay [s]; 0 without any.
  double offset_s() const;
  /// Stamp minus arrival of the quickest measurement of the last ten minutes, without windows whose quickest one is not
  /// usable; nothing without any.
  std::optional<Duration> best_offset(const UsableOffsets& usable = {}) const;
  /// Seconds per second by which the sensor's clock is fast; 0 with less than three windows.
  double drift() const;

 private:
  struct Window {
    Time begin{};
    Time at{};         // arrival of the quickest
    double least_s{};  // its arrival minus stamp
  };
  std::deque<Window> windows_;
};

}  // namespace waymark::host
