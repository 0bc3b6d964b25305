// SPDX-License-Identifier: Apache-2.0
#include "monitoring/clock_monitor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "waymark/interface/payloads.hpp"

namespace waymark::monitoring {

namespace {

/// From this many repetitions on an equal stamp is a stuck clock; fewer may be several readings of one time.
constexpr int kStuck = 10;
/// A jump is accepted after this many measurements that agree: the clock was set.
constexpr int kAgreeing = 5;
/// A zero stamp is valid only in a log that begins near zero.
constexpr Duration kZeroIsPlausible = std::chrono::hours(24);

double seconds(Time time) { return to_seconds(time.time_since_epoch()); }

}  // namespace

std::optional<std::string> ClockMonitor::fault(const Measurement& m, Duration delay) {
  Arrivals& sensor = sensors_[m.sensor];
  ++sensor.count;
  std::optional<std::string> found;
  if (is_stamp(m.stamp) && is_stamp(m.arrival)) {
    found = find_fault(m, delay, sensor);
  } else {
    found = "stamp or arrival lies more than 146 years from the epoch: it is not a valid time";
  }
  if (found) {
    ++sensor.mistimed;
    return found;
  }
  now_ = std::max(now_.value_or(m.arrival), m.arrival);
  if (sensor.timed++ == 0) {
    sensor.first = sensor.newest = m.stamp;
  } else {
    if (m.stamp < sensor.newest) ++sensor.reordered;
    sensor.first = std::min(sensor.first, m.stamp);
    sensor.gap_max = std::max(sensor.gap_max, m.stamp - sensor.newest);
    sensor.newest = std::max(sensor.newest, m.stamp);
  }
  const double latency = to_seconds(m.arrival - m.stamp);
  sensor.latency_sum += latency;
  sensor.latency_max = std::max(sensor.latency_max, latency);
  return std::nullopt;
}

std::optional<std::string> ClockMonitor::find_fault(const Measurement& m, Duration delay, Arrivals& sensor) {
  sensor.equal_in_a_row = sensor.count > 1 && m.stamp == sensor.previous ? sensor.equal_in_a_row + 1 : 0;
  sensor.previous = m.stamp;
  if (m.stamp == Time{} && m.arrival - m.stamp > kZeroIsPlausible) return "zero stamp: the clock was never set";
  if (m.stamp - m.arrival > settings_.max_ahead - std::min(delay, Duration::zero())) {
    return fmt::format("stamp {:.3f} s after its own arrival: the clock is ahead", to_seconds(m.stamp - m.arrival));
  }
  if (sensor.equal_in_a_row >= kStuck) {
    return fmt::format("stamp {:.3f} for the {}th time in a row: the clock is stuck", seconds(m.stamp),
                       sensor.equal_in_a_row + 1);
  }
  measures_steps_ = measures_steps_ || (m.payload && m.payload->type() == PoseIncrement::kType);
  if (now_ && m.stamp - *now_ > longest_step()) {
    // One stamp years ahead would make all others late; several that agree are a clock that was set.
    const bool agrees =
        jumps_in_a_row_ > 0 && m.stamp - jumped_to_ < settings_.max_jump && jumped_to_ - m.stamp < settings_.max_jump;
    jumps_in_a_row_ = agrees ? jumps_in_a_row_ + 1 : 1;
    jumped_to_ = m.stamp;
    if (jumps_in_a_row_ < kAgreeing) {
      return fmt::format("stamp {:.3f} lies {:.3g} s after all others: the clock jumped, or nothing was measured",
                         seconds(m.stamp), to_seconds(m.stamp - *now_));
    }
  }
  jumps_in_a_row_ = 0;
  if (now_ && *now_ - m.stamp > settings_.max_jump) {
    if (m.arrival - m.stamp > settings_.max_jump) {
      return fmt::format("stamp {:.3f} lies {:.3g} s before the time of arrival: another clock, or an old message",
                         seconds(m.stamp), to_seconds(m.arrival - m.stamp));
    }
    return fmt::format("stamp {:.3f} lies {:.3g} s before all others: the clock went backwards", seconds(m.stamp),
                       to_seconds(*now_ - m.stamp));
  }
  return std::nullopt;
}

/// Steps of odometry measure the motion in a gap, so only a clock that jumped makes it a new start.
Duration ClockMonitor::longest_step() const {
  return measures_steps_ ? settings_.max_jump : std::min(settings_.max_jump, settings_.max_gap);
}

void ClockMonitor::report(std::size_t index, SensorReport& report) const {
  const Arrivals& sensor = sensors_[index];
  report.measurements = sensor.count;
  report.reordered = sensor.reordered;
  report.mistimed = sensor.mistimed;
  if (sensor.timed == 0) return;
  report.first = sensor.first;
  report.last = sensor.newest;
  report.latency_mean_s = sensor.latency_sum / static_cast<double>(sensor.timed);
  report.latency_max_s = sensor.latency_max;
  report.gap_max_s = to_seconds(sensor.gap_max);
}

}  // namespace waymark::monitoring
