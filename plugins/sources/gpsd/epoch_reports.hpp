// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gps.h>

#include <memory>
#include <optional>
#include <string>

#include "waymark/base/time.hpp"
#include "waymark/interface/payloads.hpp"

// libgps changes the layout of its structures with this number.
static_assert(GPSD_API_MAJOR_VERSION >= 10, "libgps of gpsd 3.21 or newer is expected");

namespace waymark::gpsd {

/// A fix with the time that the receiver gives it.
struct TimedFix {
  Time stamp;
  std::shared_ptr<const GnssFix> fix;
};

/// Puts the reports of gpsd together: those of one time become one fix.
class EpochReports {
 public:
  EpochReports();

  /// Takes a line of gpsd. Returns the fix of the time before, if the line begins a new one.
  std::optional<TimedFix> take(const std::string& line);
  /// True if there is something to finish.
  bool is_waiting() const { return current_.has_value(); }
  /// The fix of the current time, which counts as complete from now on.
  std::optional<TimedFix> finish();
  /// Forgets the current time: the connection was lost.
  void forget() { current_.reset(); }
  /// Release of gpsd, as it reports it; empty before.
  const std::string& release() const { return release_; }

 private:
  struct Sigmas {
    double horizontal_m;
    double vertical_m;
  };
  struct Epoch {
    Time stamp;
    std::optional<gps_fix_t> fix;
    std::optional<Sigmas> sigmas;
  };

  std::optional<TimedFix> begin(Time stamp);
  Sigmas read_sigmas() const;
  std::shared_ptr<const GnssFix> fix_of(const Epoch& epoch) const;

  std::unique_ptr<gps_data_t> data_;  // large; the dilution stays in it
  int satellites_ = -1;               // of the last report that lists them
  std::optional<Epoch> current_;
  std::optional<Time> finished_;  // the last time that is complete
  std::string release_;
};

}  // namespace waymark::gpsd
