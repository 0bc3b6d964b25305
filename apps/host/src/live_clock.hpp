// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

#include "waymark/base/time.hpp"

namespace waymark::host {

/// The clock of arrivals: steady, and in UTC as it was when the program started. A step of the system's clock does not
/// move it.
class LiveClock {
 public:
  LiveClock()
      : utc_start_(std::chrono::time_point_cast<Duration>(std::chrono::system_clock::now())),
        steady_start_(std::chrono::steady_clock::now()) {}

  Time now() const { return utc_start_ + (std::chrono::steady_clock::now() - steady_start_); }

 private:
  Time utc_start_;
  std::chrono::steady_clock::time_point steady_start_;
};

}  // namespace waymark::host
