// SPDX-License-Identifier: Apache-2.0
#include "sentence.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>

namespace waymark::nmea {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

std::string quoted(std::string_view text) {
  std::string shown(text.substr(0, 40));
  std::ranges::replace_if(
      shown, [](char c) { return c < ' ' || c > '~'; }, '?');
  return '"' + shown + '"';
}

/// A number of digits at the start of a text.
int digits(std::string_view text, std::size_t from, std::size_t count) {
  int value = 0;
  for (const char c : text.substr(from, count)) value = 10 * value + (c - '0');
  return value;
}

bool starts_with_digits(std::string_view text, std::size_t count) {
  return text.size() >= count && std::ranges::all_of(text.substr(0, count), is_digit);
}

std::string_view check(std::string_view body, bool needs_checksum) {
  const std::size_t star = body.rfind('*');
  if (star == std::string_view::npos) {
    if (needs_checksum) throw Unusable(quoted(body) + " has no checksum");
    return body;
  }
  std::uint8_t sum = 0;
  for (const char c : body.substr(0, star)) sum = static_cast<std::uint8_t>(sum ^ static_cast<std::uint8_t>(c));
  const std::string_view given = body.substr(star + 1);
  unsigned value = 0;
  const auto [end, error] = std::from_chars(given.data(), given.data() + given.size(), value, 16);
  const bool is_number = error == std::errc{} && end - given.data() == 2 &&
                         std::ranges::all_of(given.substr(2), [](char c) { return c == ' ' || c == '\t'; });
  if (!is_number || value != sum)
    throw Unusable(fmt::format("{}: the checksum is {}, but {:02X} is right", quoted(body), quoted(given), sum));
  return body.substr(0, star);
}

}  // namespace

std::optional<Sentence> read_sentence(std::string_view line, bool needs_checksum) {
  if (line.starts_with('#') || line.starts_with('!')) return std::nullopt;
  if (line.find_first_not_of(" \t") == std::string_view::npos) return std::nullopt;
  // What stands before a dollar sign is the rest of a sentence that lost its end.
  const std::size_t dollar = line.rfind('$');
  if (dollar == std::string_view::npos) throw Unusable(quoted(line) + " is not a sentence; \"$\" is expected");
  std::string_view body = line.substr(dollar + 1);
  if (body.starts_with('P')) return std::nullopt;
  body = check(body, needs_checksum);
  Sentence sentence;
  const std::size_t comma = std::min(body.find(','), body.size());
  if (comma != 5) throw Unusable(quoted(body) + " does not begin with a talker and a type of two and three letters");
  sentence.talker = body.substr(0, 2);
  sentence.type = body.substr(2, 3);
  for (std::size_t from = comma; from < body.size();) {
    const std::size_t next = std::min(body.find(',', from + 1), body.size());
    sentence.fields.push_back(body.substr(from + 1, next - from - 1));
    from = next;
  }
  return sentence;
}

std::optional<double> Sentence::number(std::size_t index) const {
  const std::string_view text = field(index);
  if (text.empty()) return std::nullopt;
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value))
    throw Unusable(fmt::format("{}: field {} is {}, a number is expected", type, index + 1, quoted(text)));
  return value;
}

std::optional<int> Sentence::whole_number(std::size_t index) const {
  const std::string_view text = field(index);
  if (text.empty()) return std::nullopt;
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size())
    throw Unusable(fmt::format("{}: field {} is {}, a whole number is expected", type, index + 1, quoted(text)));
  return value;
}

std::optional<Duration> Sentence::time_of_day(std::size_t index) const {
  const std::string_view text = field(index);
  if (text.empty()) return std::nullopt;
  const auto fail = [&] {
    throw Unusable(fmt::format("{}: field {} is {}, a time as 235959.99 is expected", type, index + 1, quoted(text)));
  };
  if (!starts_with_digits(text, 6)) fail();
  const int hours = digits(text, 0, 2);
  const int minutes = digits(text, 2, 2);
  const int seconds = digits(text, 4, 2);
  if (hours > 23 || minutes > 59 || seconds > 60) fail();  // 60: a leap second
  std::int64_t nanoseconds = 0;
  if (text.size() > 6) {
    if (text[6] != '.' || !std::ranges::all_of(text.substr(7), is_digit)) fail();
    for (std::size_t i = 7; i < 16; ++i) nanoseconds = 10 * nanoseconds + (i < text.size() ? text[i] - '0' : 0);
  }
  return std::chrono::hours(hours) + std::chrono::minutes(minutes) + std::chrono::seconds(seconds) +
         Duration(nanoseconds);
}

std::optional<std::chrono::sys_days> Sentence::date(std::size_t index) const {
  const std::string_view text = field(index);
  if (text.empty()) return std::nullopt;
  constexpr int kFirstOfLastCentury = 80;  // GPS time begins in 1980
  if (text.size() == 6 && starts_with_digits(text, 6)) {
    const int year = digits(text, 4, 2);
    const std::chrono::year_month_day day(std::chrono::year(year + (year < kFirstOfLastCentury ? 2000 : 1900)),
                                          std::chrono::month(static_cast<unsigned>(digits(text, 2, 2))),
                                          std::chrono::day(static_cast<unsigned>(digits(text, 0, 2))));
    if (day.ok()) return std::chrono::sys_days(day);
  }
  throw Unusable(fmt::format("{}: field {} is {}, a date as 311224 is expected", type, index + 1, quoted(text)));
}

std::optional<double> Sentence::angle(std::size_t index, char positive, char negative, double limit) const {
  const std::string_view text = field(index);
  const std::string_view side = field(index + 1);
  if (text.empty()) return std::nullopt;
  const auto fail = [&] {
    throw Unusable(fmt::format("{}: fields {} and {} are {} and {}, an angle as 4900.1234,{} is expected", type,
                               index + 1, index + 2, quoted(text), quoted(side), positive));
  };
  const std::size_t point = std::min(text.find('.'), text.size());
  if (point < 3 || point > 5 || !starts_with_digits(text, point) || side.size() != 1 ||
      (side[0] != positive && side[0] != negative)) {
    fail();
  }
  double minutes = 0.0;
  const char* end = text.data() + text.size();
  const auto parsed = std::from_chars(text.data() + point - 2, end, minutes);
  if (parsed.ec != std::errc{} || parsed.ptr != end || !(minutes < 60.0)) fail();
  const double degrees = digits(text, 0, point - 2) + minutes / 60.0;
  if (degrees > limit) fail();
  return side[0] == positive ? degrees : -degrees;
}

}  // namespace waymark::nmea
