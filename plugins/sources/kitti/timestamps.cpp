// SPDX-License-Identifier: Apache-2.0
#include "timestamps.hpp"

#include <fmt/format.h>

#include <charconv>
#include <fstream>
#include <string>

#include "waymark/base/error.hpp"

namespace waymark::kitti {
namespace {

/// `count` digits at the start of `text`, which is shortened by them and by the separator behind them.
int take_number(std::string_view& text, std::size_t count, char separator) {
  int value = 0;
  const bool long_enough = text.size() > count && text[count] == separator;
  const char* end = text.data() + count;
  if (!long_enough || std::from_chars(text.data(), end, value).ptr != end || value < 0) {
    throw DataError("a time as 2011-09-26 13:02:25.951199337 is expected");
  }
  text.remove_prefix(count + 1);
  return value;
}

}  // namespace

Time parse_timestamp(std::string_view text) {
  const std::string given(text);
  try {
    const std::chrono::year year(take_number(text, 4, '-'));
    const std::chrono::month month(static_cast<unsigned>(take_number(text, 2, '-')));
    const std::chrono::day day(static_cast<unsigned>(take_number(text, 2, ' ')));
    const std::chrono::year_month_day date(year, month, day);
    const int hours = take_number(text, 2, ':');
    const int minutes = take_number(text, 2, ':');
    const Time seconds = parse_time(text);  // "25.951199337"
    constexpr Duration kMinute = std::chrono::minutes(1);
    const Duration within = seconds.time_since_epoch();
    if (!date.ok() || hours > 23 || minutes > 59 || within < Duration{} || within >= kMinute)
      throw DataError("it is not a valid time");
    const auto stamp =
        stamp_on(std::chrono::sys_days(date), std::chrono::hours(hours) + std::chrono::minutes(minutes) + within);
    if (!stamp) throw DataError("the year is not a year of a stamp; 1824 to 2115 are");
    return *stamp;
  } catch (const DataError& error) {
    throw DataError(fmt::format("\"{}\": {}", given.substr(0, 60), error.what()));
  }
}

std::vector<Time> read_timestamps(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) throw DataError(file.string() + ": cannot be read");
  std::vector<Time> stamps;
  for (std::string line; std::getline(in, line);) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.empty() && in.peek() == std::ifstream::traits_type::eof()) break;
    try {
      stamps.push_back(parse_timestamp(line));
    } catch (const DataError& error) {
      throw DataError(fmt::format("{}:{}: {}", file.string(), stamps.size() + 1, error.what()));
    }
  }
  return stamps;
}

}  // namespace waymark::kitti
