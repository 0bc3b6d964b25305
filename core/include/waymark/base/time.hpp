// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include "waymark/base/api.hpp"

namespace waymark {

/// A duration, int64 nanoseconds.
using Duration = std::chrono::nanoseconds;

/// A point in time: int64 nanoseconds since an epoch that the source defines. Never a double.
using Time = std::chrono::sys_time<Duration>;

/// Seconds as a double, for use in models only.
constexpr double to_seconds(Duration duration) { return 1e-9 * static_cast<double>(duration.count()); }

/// Half of the int64 range, 146 years. Stamps lie within it around the epoch (1823 to 2116), and settings saturate at
/// it: neither the difference of two stamps, nor a stamp plus or minus a setting, nor the sum of two settings
/// overflows.
inline constexpr Duration kLongest{std::numeric_limits<std::int64_t>::max() / 2};

/// Rounded to the nearest nanosecond. For durations and settings only; stamps of a log are read with `parse_time`. What
/// is longer than `kLongest` is `kLongest`: a limit that is never reached. So is NaN.
constexpr Duration from_seconds(double seconds) {
  constexpr auto kMost = static_cast<double>(kLongest.count());
  const double nanoseconds = seconds * 1e9 + (seconds < 0.0 ? -0.5 : 0.5);
  if (nanoseconds <= -kMost) return -kLongest;
  return nanoseconds < kMost ? Duration{static_cast<std::int64_t>(nanoseconds)} : kLongest;
}

/// True if a source may deliver `time` as a stamp: it lies within `kLongest` of the epoch.
constexpr bool is_stamp(Time time) {
  return time.time_since_epoch() <= kLongest && time.time_since_epoch() >= -kLongest;
}

/// `stamp` moved by `by`; nothing if that is not a stamp. Both may have any value.
constexpr std::optional<Time> moved(Time stamp, Duration by) {
  std::int64_t sum = 0;
  if (__builtin_add_overflow(stamp.time_since_epoch().count(), by.count(), &sum)) return std::nullopt;
  const Time result{Duration{sum}};
  return is_stamp(result) ? std::optional(result) : std::nullopt;
}

/// The stamp `within` after the midnight that begins `day`; nothing if that is not a stamp.
constexpr std::optional<Time> stamp_on(std::chrono::sys_days day, Duration within) {
  constexpr auto kMostDays = std::chrono::floor<std::chrono::days>(kLongest);
  const std::chrono::days days = day.time_since_epoch();
  if (days > kMostDays || days < -kMostDays) return std::nullopt;
  return moved(Time{days}, within);
}

/// The stamp `count` periods after the epoch; nothing if that is not a stamp.
constexpr std::optional<Time> stamp_after(std::uint64_t count, Duration period) {
  std::int64_t nanoseconds = 0;
  if (__builtin_mul_overflow(count, period.count(), &nanoseconds)) return std::nullopt;
  return moved(Time{}, Duration{nanoseconds});
}

/// Reads decimal seconds ("1248272272.841", "-0.5", "1e-3") without conversion to double. Digits beyond the nanosecond
/// are rounded. Throws DataError if the text is not a finite number or no stamp.
WAYMARK_API Time parse_time(std::string_view decimal_seconds);

/// Decimal seconds with nine digits, the inverse of `parse_time`.
WAYMARK_API std::string format_time(Time time);
/// The same, rounded to `digits` of them, 0 to 9: for messages.
WAYMARK_API std::string format_time(Time time, int digits);

}  // namespace waymark
