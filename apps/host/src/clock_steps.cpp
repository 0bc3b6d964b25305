// SPDX-License-Identifier: Apache-2.0
#include "clock_steps.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

namespace waymark::host {
namespace {

/// Less cannot be distinguished from measurements that are delayed or out of order.
constexpr Duration kLeastStep = std::chrono::seconds(2);
/// Stamps of one clock agree within its delays.
constexpr double kAgreement = 0.5;  // [s]
constexpr int kAgreeing = 5;
/// What was stored and is sent at once has old stamps, too, but not for so long.
constexpr Duration kSettling = std::chrono::seconds(1);

}  // namespace

bool ClockSteps::is_suspect(Time stamp, Time arrival, std::optional<Duration> best_offset) const {
  if (!best_offset || fitting_ < kAgreeing) return false;
  const Duration offset = stamp - arrival;
  // What was stored while nobody took it comes at once, with smaller and smaller delays, but without a leap.
  const bool leaps = stamp - newest_ > arrival - newest_arrival_ + kLeastStep;
  const bool is_back = stamp < newest_ - kLeastStep;
  return (leaps && offset > *best_offset + kLeastStep) || (is_back && offset < *best_offset - kLeastStep);
}

Time ClockSteps::corrected(Time stamp, Time arrival, std::optional<Duration> best_offset, const UsableOffsets& usable) {
  if (!is_stamp(stamp) || !is_stamp(arrival)) return stamp;
  const std::optional<Time> moved_stamp = moved(stamp, -total_);
  if (!moved_stamp) return stamp;
  if (!is_suspect(*moved_stamp, arrival, best_offset)) {
    suspects_ = 0;
    if (!usable.contains(*moved_stamp - arrival)) return *moved_stamp;
    fitting_ = std::min(fitting_ + 1, kAgreeing);
    if (*moved_stamp >= newest_ || fitting_ == 1) {
      newest_ = *moved_stamp;
      newest_arrival_ = arrival;
    }
    return *moved_stamp;
  }
  const Duration offset = *moved_stamp - arrival;
  const bool agrees = suspects_ > 0 && std::abs(to_seconds(offset) - to_seconds(first_offset_)) < kAgreement;
  if (!agrees) {
    suspects_ = 0;
    first_arrival_ = arrival;
    first_offset_ = best_suspect_ = offset;
  }
  ++suspects_;
  best_suspect_ = std::max(best_suspect_, offset);
  if (suspects_ < kAgreeing || arrival - first_arrival_ < kSettling) return *moved_stamp;
  // As doubles, which do not overflow; 0.2 µs are lost over 50 years.
  step_ = from_seconds(to_seconds(best_suspect_) - to_seconds(*best_offset));
  total_ = from_seconds(to_seconds(total_) + to_seconds(*step_));
  suspects_ = 0;
  newest_ = moved(stamp, -total_).value_or(arrival);
  newest_arrival_ = arrival;
  return newest_;
}

std::optional<Duration> ClockSteps::take_step() { return std::exchange(step_, std::nullopt); }

}  // namespace waymark::host
