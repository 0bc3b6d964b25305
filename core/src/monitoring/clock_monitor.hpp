// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "waymark/base/error.hpp"
#include "waymark/host/fusion_settings.hpp"
#include "waymark/interface/measurement.hpp"
#include "waymark/interface/snapshot.hpp"

namespace waymark::monitoring {

/// Checks the stamps of all sensors, in order of arrival: separates implausible stamps from late ones, and keeps
/// statistics of the arrivals. "Now" is the newest arrival in the data, never a clock.
class ClockMonitor {
 public:
  ClockMonitor(const ClockSettings& settings, std::size_t sensors) : settings_(settings), sensors_(sensors) {}

  /// The fault of this stamp, as a text for users, or nothing. Call it once per measurement. `delay`: what the YAML has
  /// subtracted from the stamp; a negative one may carry it beyond the arrival.
  std::optional<std::string> fault(const Measurement& m, Duration delay = {});

  /// Fills in the statistics of the arrivals: counts, first and last stamp, latency, longest gap.
  void report(std::size_t sensor, SensorReport& report) const;

  /// Reading throws DataError if the checkpoint is of another configuration.
  template <class Archive>
  void serialize(Archive& archive) {
    auto count = static_cast<std::uint64_t>(sensors_.size());
    archive(count);
    if (count != sensors_.size()) throw DataError("the checkpoint has another number of sensors");
    for (Arrivals& sensor : sensors_) archive(sensor);
    archive(now_, measures_steps_, jumps_in_a_row_, jumped_to_);
  }

 private:
  struct Arrivals {
    std::uint64_t count = 0;
    std::uint64_t reordered = 0;
    std::uint64_t mistimed = 0;
    std::uint64_t timed = 0;  // with a plausible stamp
    int equal_in_a_row = 0;
    Time first{};
    Time newest{};
    Time previous{};
    double latency_sum = 0.0;
    double latency_max = 0.0;
    Duration gap_max{};

    template <class Archive>
    void serialize(Archive& archive) {
      archive(count, reordered, mistimed, timed, equal_in_a_row, first, newest, previous, latency_sum, latency_max,
              gap_max);
    }
  };
  std::optional<std::string> find_fault(const Measurement& m, Duration delay, Arrivals& sensor);
  Duration longest_step() const;

  ClockSettings settings_;
  std::vector<Arrivals> sensors_;
  std::optional<Time> now_;      // newest arrival with a plausible stamp
  bool measures_steps_ = false;  // some sensor delivers increments
  int jumps_in_a_row_ = 0;
  Time jumped_to_{};
};

}  // namespace waymark::monitoring
