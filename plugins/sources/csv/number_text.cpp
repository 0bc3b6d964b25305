// SPDX-License-Identifier: Apache-2.0
#include "number_text.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>
#include <system_error>

namespace waymark::csv {
namespace {

constexpr std::array<double, 16> kPowersOfTen = {1e0, 1e1, 1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                                 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15};

bool is_digit(char c) { return c >= '0' && c <= '9'; }

// Up to 15 digits are exact in a double and so is their power of ten: one division rounds correctly.
bool parse_short_decimal(std::string_view text, double& value) {
  const char* at = text.data();
  const char* const end = at + text.size();
  const bool negative = *at == '-';
  if (negative) ++at;
  if (end - at > 16) return false;
  std::int64_t mantissa = 0;
  int digits = 0;
  for (; at != end && is_digit(*at); ++at, ++digits) mantissa = 10 * mantissa + (*at - '0');
  std::size_t decimals = 0;
  if (at != end && *at == '.') {
    for (++at; at != end && is_digit(*at); ++at, ++digits, ++decimals) mantissa = 10 * mantissa + (*at - '0');
  }
  if (at != end || digits == 0 || digits > 15) return false;
  value = static_cast<double>(mantissa) / kPowersOfTen[decimals];
  if (negative) value = -value;
  return true;
}

// Decimal digits as an integer of up to 19 digits times a power of ten.
struct Decimal {
  std::uint64_t mantissa = 0;
  std::int64_t exponent = 0;
  bool negative = false;
  bool round_up = false;  // the first digit that did not fit was 5 or more
};

bool parse_decimal(std::string_view text, Decimal& decimal) {
  constexpr int kDigits = 19;
  const char* at = text.data();
  const char* const end = at + text.size();
  if (at != end && (*at == '-' || *at == '+')) decimal.negative = *at++ == '-';
  int kept = 0;
  bool any = false;
  bool dropped = false;
  bool fraction = false;
  for (; at != end; ++at) {
    if (*at == '.' && !fraction) {
      fraction = true;
      continue;
    }
    if (!is_digit(*at)) break;
    any = true;
    if (kept < kDigits) {
      decimal.mantissa = 10 * decimal.mantissa + static_cast<std::uint64_t>(*at - '0');
      if (decimal.mantissa != 0) ++kept;
      if (fraction) --decimal.exponent;
    } else {
      if (!dropped) decimal.round_up = *at >= '5';
      dropped = true;
      if (!fraction) ++decimal.exponent;
    }
  }
  if (!any) return false;
  if (at == end) return true;
  if (*at != 'e' && *at != 'E') return false;
  ++at;
  if (at != end && *at == '+') ++at;
  int exponent = 0;
  const auto [stop, error] = std::from_chars(at, end, exponent);
  if (error != std::errc{} || stop != end || exponent > 10000 || exponent < -10000) return false;
  decimal.exponent += exponent;
  return true;
}

}  // namespace

NumberText parse_number(std::string_view text, double& value) {
  if (text.empty()) return NumberText::empty;
  if (parse_short_decimal(text, value)) return NumberText::ok;
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);  // from_chars accepts no plus sign
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (stop != text.data() + text.size() || error == std::errc::invalid_argument) return NumberText::not_a_number;
  return error == std::errc{} ? NumberText::ok : NumberText::out_of_range;
}

NumberText parse_nanoseconds(std::string_view text, int exponent, std::int64_t& nanoseconds) {
  if (text.empty()) return NumberText::empty;
  Decimal decimal;
  if (!parse_decimal(text, decimal)) return NumberText::not_a_number;
  constexpr auto kMost = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  std::uint64_t value = decimal.mantissa;
  std::int64_t power = decimal.exponent + exponent + 9;
  if (power == 0 && decimal.round_up) ++value;
  for (; power > 0 && value != 0; --power) {
    if (value > kMost / 10) return NumberText::out_of_range;
    value *= 10;
  }
  if (power < 0) {
    for (; power < -1 && value != 0; ++power) value /= 10;
    value = value / 10 + (value % 10 >= 5 ? 1 : 0);
  }
  if (value > kMost) return NumberText::out_of_range;
  nanoseconds = decimal.negative ? -static_cast<std::int64_t>(value) : static_cast<std::int64_t>(value);
  return NumberText::ok;
}

std::string in_quotes(std::string_view text) {
  constexpr std::size_t kLongest = 40;
  std::string result(text.substr(0, kLongest));
  std::ranges::replace_if(
      result, [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
  return '"' + result + (text.size() > kLongest ? "…\"" : "\"");
}

}  // namespace waymark::csv
