// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "waymark/host/fusion_settings.hpp"
#include "waymark/interface/measurement.hpp"
#include "waymark/interface/snapshot.hpp"

namespace waymark::monitoring {

/// Watches the stamps of all sensors, in order of arrival: separates those that cannot be right from those that are
/// merely late, and keeps the statistics of arrival. "Now" is the newest arrival in the data, never a clock.
class ClockMonitor {
 public:
  ClockMonitor(const ClockSettings& settings, std::size_t sensors) : settings_(settings), sensors_(sensors) {}

  /// The fault of this stamp as a name for the user, or nothing. Every measurement must be shown once.
  std::optional<std::string> fault(const Measurement& m);

  /// Fills in what is known from arrivals alone: counts, rate, latency, gaps.
  void report(std::size_t sensor, SensorReport& report) const;

 private:
  struct Arrivals {
    std::uint64_t count = 0;
    std::uint64_t reordered = 0;
    std::uint64_t mistimed = 0;
    std::uint64_t timed = 0;  // with a believable stamp
    int equal_in_a_row = 0;
    Time first{};
    Time newest{};
    Time previous{};
    double latency_sum = 0.0;
    double latency_max = 0.0;
    Duration gap_max{};
  };
  std::optional<std::string> find_fault(const Measurement& m, Arrivals& sensor);

  ClockSettings settings_;
  std::vector<Arrivals> sensors_;
  std::optional<Time> now_;  // newest believable arrival
  int jumps_in_a_row_ = 0;
  Time jumped_to_{};
};

}  // namespace waymark::monitoring
