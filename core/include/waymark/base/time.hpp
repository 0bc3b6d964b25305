// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
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

/// Rounded to the nearest nanosecond. For durations and settings only; stamps of a log are read with `parse_time`.
constexpr Duration from_seconds(double seconds) {
  return Duration{static_cast<std::int64_t>(seconds * 1e9 + (seconds < 0.0 ? -0.5 : 0.5))};
}

/// Reads decimal seconds ("1248272272.841", "-0.5", "1e-3") without conversion to double. Digits beyond the nanosecond
/// are rounded. Throws DataError if the text is not a finite number or exceeds the int64 range.
WAYMARK_API Time parse_time(std::string_view decimal_seconds);

/// Decimal seconds with nine digits, the inverse of `parse_time`.
WAYMARK_API std::string format_time(Time time);

}  // namespace waymark
