// SPDX-License-Identifier: Apache-2.0
#include "waymark/base/time.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <cstdlib>
#include <string>

#include "waymark/base/error.hpp"

namespace waymark {
namespace {

constexpr int kNanosecondDigits = 9;
constexpr int kMaxDigits = 20;  // more than 2^63 has
constexpr std::string_view kNoStamp = "s is not a stamp: it lies more than 146 years from the epoch";

[[noreturn]] void refuse(std::string_view text, std::string_view why) {
  throw DataError(fmt::format("\"{}\" {}", text, why));
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

std::string_view trim(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

/// A decimal number 0.d1d2d3… × 10^point, exactly as it was written.
struct Decimal {
  bool negative = false;
  std::string digits;
  std::int64_t point = 0;
};

/// Consumes a sign; returns whether it was a minus.
bool take_sign(std::string_view& rest) {
  if (rest.empty() || (rest.front() != '+' && rest.front() != '-')) return false;
  const bool negative = rest.front() == '-';
  rest.remove_prefix(1);
  return negative;
}

Decimal read_decimal(std::string_view text) {
  std::string_view rest = trim(text);
  Decimal number;
  number.negative = take_sign(rest);
  bool after_point = false;
  bool any = false;
  for (; !rest.empty(); rest.remove_prefix(1)) {
    const char c = rest.front();
    if (is_digit(c)) {
      any = true;
      // A leading zero carries no value, only a place behind the point.
      if (c != '0' || !number.digits.empty()) {
        number.digits += c;
        if (!after_point) ++number.point;
      } else if (after_point) {
        --number.point;
      }
    } else if (c == '.' && !after_point) {
      after_point = true;
    } else {
      break;
    }
  }
  if (!any) refuse(text, "is not a time in seconds");
  if (!rest.empty() && (rest.front() == 'e' || rest.front() == 'E')) {
    rest.remove_prefix(1);
    const bool negative = take_sign(rest);
    if (rest.empty() || !is_digit(rest.front())) refuse(text, "is not a time in seconds");
    std::int64_t exponent = 0;
    for (; !rest.empty() && is_digit(rest.front()); rest.remove_prefix(1)) {
      if (exponent < 1'000'000'000'000) exponent = 10 * exponent + (rest.front() - '0');
    }
    number.point += negative ? -exponent : exponent;
  }
  if (!rest.empty()) refuse(text, "is not a time in seconds");
  return number;
}

}  // namespace

Time parse_time(std::string_view decimal_seconds) {
  const Decimal number = read_decimal(decimal_seconds);
  if (number.digits.empty()) return Time{};
  const std::int64_t places = number.point + kNanosecondDigits;  // digits before the nanosecond's point
  if (places > kMaxDigits) refuse(decimal_seconds, kNoStamp);
  if (places < 0) return Time{};
  __extension__ using Wide = unsigned __int128;
  Wide nanoseconds = 0;
  for (std::int64_t i = 0; i < places; ++i) {
    const auto index = static_cast<std::size_t>(i);
    nanoseconds =
        10 * nanoseconds + static_cast<unsigned>(index < number.digits.size() ? number.digits[index] - '0' : 0);
  }
  const auto next = static_cast<std::size_t>(places);
  if (next < number.digits.size() && number.digits[next] >= '5') ++nanoseconds;
  if (nanoseconds > static_cast<Wide>(kLongest.count())) refuse(decimal_seconds, kNoStamp);
  const auto magnitude = static_cast<std::int64_t>(nanoseconds);
  return Time{Duration{number.negative ? -magnitude : magnitude}};
}

std::string format_time(Time time, int digits) {
  std::int64_t unit = 1;
  for (int i = digits; i < kNanosecondDigits; ++i) unit *= 10;
  const std::int64_t count = time.time_since_epoch().count();
  // Away from zero, without an overflow at the ends of the range.
  const std::int64_t rest = count % unit;
  std::int64_t rounded = count - rest;
  if (2 * std::abs(rest) >= unit && is_stamp(time)) rounded += count < 0 ? -unit : unit;
  std::string text = format_time(Time{Duration{rounded}});
  text.resize(text.size() - static_cast<std::size_t>(digits > 0 ? kNanosecondDigits - digits : kNanosecondDigits + 1));
  return text;
}

std::string format_time(Time time) {
  const std::int64_t count = time.time_since_epoch().count();
  const auto bits = static_cast<std::uint64_t>(count);
  const std::uint64_t magnitude = count < 0 ? ~bits + 1 : bits;
  return fmt::format("{}{}.{:09}", count < 0 ? "-" : "", magnitude / 1'000'000'000, magnitude % 1'000'000'000);
}

}  // namespace waymark
