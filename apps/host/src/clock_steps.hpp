// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "clock_offset.hpp"
#include "waymark/base/time.hpp"

namespace waymark::host {

/// Finds out that a sensor's clock was set, by NTP or by a restart, and carries its stamps on as if it had not been: an
/// estimator's time neither jumps nor goes back.
///
/// Stamp minus arrival is the clock's offset less a delay. A delay is never negative, so a stamp that leaps beyond what
/// the best offset allows is of a clock that was set forward; one that lies before the sensor's newest stamp is of a
/// clock that was set back, or out of order. A step counts once five in a row agree on it for a second; until then
/// stamps are passed on as they are, and the filter refuses them. So it does with a clock that is wrong from the start,
/// such as a receiver's before its first fix: once that one is right, its stamps are not carried on.
class ClockSteps {
 public:
  /// The stamp without the steps so far. `best_offset`: stamp minus arrival of the quickest measurement that
  /// `corrected` returned lately, of the usable ones; nothing if there is none.
  Time corrected(Time stamp, Time arrival, std::optional<Duration> best_offset, const UsableOffsets& usable = {});

  /// The last step, once: positive if the clock was set forward.
  std::optional<Duration> take_step();
  /// All steps together.
  Duration total() const { return total_; }
  /// True while stamps do not fit and no step is sure yet: they carry no information about the offset.
  bool in_doubt() const { return suspects_ > 0; }

 private:
  bool is_suspect(Time stamp, Time arrival, std::optional<Duration> best_offset) const;

  Duration total_{};
  std::optional<Duration> step_;
  Time newest_{};          // usable stamp, without the steps
  Time newest_arrival_{};  // of that one
  int fitting_ = 0;        // measurements, up to what makes an offset known
  // Of the suspects in a row.
  int suspects_ = 0;
  Time first_arrival_{};
  Duration first_offset_{};
  Duration best_suspect_{};
};

}  // namespace waymark::host
