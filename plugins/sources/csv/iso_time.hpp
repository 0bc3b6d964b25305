// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>

#include "waymark/base/time.hpp"

namespace waymark::csv {

/// True if the text begins as a date of ISO 8601 does, "2024-": no number does.
bool looks_like_a_date(std::string_view text);

/// Reads a date and a time of day in the extended format of ISO 8601: "2024-05-01T12:30:00.25Z". 'T' or one blank
/// between them, fraction of a second behind '.' or ',', and 'Z', "+02:00", "+0200", "+02" or nothing (UTC) at the end.
/// Digits below the nanosecond are rounded. Nothing for other texts, for a day or time that no calendar has (leap
/// seconds included: the count of seconds since 1970 has none), and for what is no stamp.
std::optional<Time> parse_iso_time(std::string_view text);

}  // namespace waymark::csv
