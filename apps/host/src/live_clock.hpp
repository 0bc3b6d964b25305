// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <memory>
#include <utility>

#include "waymark/base/time.hpp"
#include "waymark/interface/source.hpp"

namespace waymark::host {

/// The clock of arrivals: steady, and in UTC as it was when the program started. A step of the system's clock does not
/// move it. If a source has a simulated time, that is the clock.
class LiveClock {
 public:
  /// `simulation`: null, or a source that has one.
  explicit LiveClock(std::shared_ptr<const Source> simulation = nullptr)
      : simulation_(std::move(simulation)),
        utc_start_(std::chrono::time_point_cast<Duration>(std::chrono::system_clock::now())),
        steady_start_(std::chrono::steady_clock::now()) {}

  Time now() const {
    if (simulation_) {
      if (const auto simulated = simulation_->simulated_time()) return *simulated;
    }
    return utc_start_ + (std::chrono::steady_clock::now() - steady_start_);
  }

 private:
  std::shared_ptr<const Source> simulation_;
  Time utc_start_;
  std::chrono::steady_clock::time_point steady_start_;
};

}  // namespace waymark::host
