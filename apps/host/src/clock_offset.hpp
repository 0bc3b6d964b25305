// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <optional>

#include "waymark/base/time.hpp"

namespace waymark::host {

/// Offset and drift of a sensor's clock against that of the arrivals, by the minimum-delay filter (Cristian, 1989: the
/// exchange with the least delay bounds the offset best). The least delay of each window lies on the line of the
/// clocks; the delay common to all measurements remains in the offset.
class ClockOffset {
 public:
  void add(Time stamp, Time arrival);

  /// Stamp minus arrival of the quickest measurement of the last window, negative for a delay [s]; 0 without any.
  double offset_s() const;
  /// Stamp minus arrival of the quickest measurement of the last ten minutes; nothing without any.
  std::optional<Duration> best_offset() const;
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
