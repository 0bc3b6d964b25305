// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <utility>

#include "fusion/measurement_queue.hpp"
#include "monitoring/clock_monitor.hpp"

namespace waymark::fusion {

/// Admits measurements in order of arrival: checks their stamps and puts them in the total order.
class Intake {
 public:
  Intake(const ClockSettings& clock, Duration max_latency, std::size_t sensors)
      : clocks_(clock, sensors), queue_(max_latency) {}

  /// Adds one measurement and calls `turn(const Measurement&, bool is_late)` for all that are due. Returns the fault of
  /// an implausible stamp; the measurement is then dropped.
  /// `delay`: what was subtracted from the stamp already; of a sensor whose stamps are early it is negative.
  template <class Turn>
  std::optional<std::string> admit(const Measurement& m, Duration delay, const Turn& turn) {
    if (auto fault = clocks_.fault(m, delay)) return fault;
    if (!queue_.push(m)) {
      turn(m, true);
      return std::nullopt;
    }
    while (auto due = queue_.pop_due()) turn(*due, false);
    return std::nullopt;
  }
  /// Calls `turn` for all buffered measurements, at the end of the log.
  template <class Turn>
  void finish(const Turn& turn) {
    while (auto next = queue_.pop()) turn(*next, false);
  }

  /// All but the waiting measurements, for a checkpoint.
  template <class Archive>
  void serialize(Archive& archive) {
    archive(clocks_, queue_);
  }
  void put_back(Measurement&& measurement) { queue_.put_back(std::move(measurement)); }

  const MeasurementQueue& queue() const { return queue_; }
  const monitoring::ClockMonitor& clocks() const { return clocks_; }

 private:
  monitoring::ClockMonitor clocks_;
  MeasurementQueue queue_;
};

}  // namespace waymark::fusion
