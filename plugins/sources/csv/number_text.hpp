// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace waymark::csv {

/// What a field turned out to be when a number was asked for.
enum class NumberText { ok, empty, not_a_number, out_of_range };

/// Reads a decimal number, correctly rounded; "nan" and "inf" are numbers here.
NumberText parse_number(std::string_view text, double& value);

/// Reads decimal units of 10^exponent seconds into nanoseconds without passing through a double; digits below the
/// nanosecond are rounded. `exponent` -3 means that the text is in milliseconds.
NumberText parse_nanoseconds(std::string_view text, int exponent, std::int64_t& nanoseconds);

/// The text for an error message: in quotes, shortened, control characters replaced.
std::string in_quotes(std::string_view text);

}  // namespace waymark::csv
