// SPDX-License-Identifier: Apache-2.0
#include "iso_time.hpp"

#include <chrono>
#include <cstdint>

namespace waymark::csv {
namespace {

bool is_decimal(char c) { return c >= '0' && c <= '9'; }

/// Takes the parts of a text from its front; `ok` is false once one was not there.
class Parts {
 public:
  explicit Parts(std::string_view text) : rest_(text) {}

  bool ok() const { return ok_; }
  bool at_end() const { return rest_.empty(); }
  char front() const { return rest_.empty() ? '\0' : rest_.front(); }

  /// A number of so many digits.
  int digits(std::size_t count) {
    int value = 0;
    for (std::size_t i = 0; i < count; ++i) {
      if (!is_decimal(front())) {
        ok_ = false;
        return 0;
      }
      value = 10 * value + (rest_.front() - '0');
      rest_.remove_prefix(1);
    }
    return value;
  }
  void require(char wanted) { ok_ = take(wanted) && ok_; }
  bool take(char wanted) {
    if (front() != wanted) return false;
    rest_.remove_prefix(1);
    return true;
  }
  /// The digits behind a decimal point [ns].
  std::int64_t fraction() {
    constexpr int kDigits = 9;
    std::int64_t value = 0;
    int count = 0;
    ok_ = is_decimal(front()) && ok_;
    for (; is_decimal(front()); rest_.remove_prefix(1), ++count) {
      if (count < kDigits) value = 10 * value + (rest_.front() - '0');
      if (count == kDigits && rest_.front() >= '5') ++value;
    }
    for (; count < kDigits; ++count) value *= 10;
    return value;
  }

 private:
  std::string_view rest_;
  bool ok_ = true;
};

/// How far the text's local time is ahead of UTC.
std::chrono::minutes read_zone(Parts& text) {
  if (text.at_end() || text.take('Z') || text.take('z')) return {};
  const bool ahead = text.take('+');
  if (!ahead) text.require('-');
  const int hours = text.digits(2);
  int minutes = 0;
  if (text.take(':') || is_decimal(text.front())) minutes = text.digits(2);
  const auto offset = std::chrono::hours(hours) + std::chrono::minutes(minutes);
  return ahead ? offset : -offset;
}

}  // namespace

bool looks_like_a_date(std::string_view text) {
  return text.size() >= 5 && is_decimal(text[0]) && is_decimal(text[1]) && is_decimal(text[2]) && is_decimal(text[3]) &&
         text[4] == '-';
}

std::optional<Time> parse_iso_time(std::string_view text) {
  using std::chrono::hours;
  using std::chrono::minutes;
  using std::chrono::seconds;
  Parts parts(text);
  const int year = parts.digits(4);
  parts.require('-');
  const int month = parts.digits(2);
  parts.require('-');
  const int day = parts.digits(2);
  if (!parts.take('T') && !parts.take('t')) parts.require(' ');
  const int hour = parts.digits(2);
  parts.require(':');
  const int minute = parts.digits(2);
  int second = 0;
  std::int64_t nanoseconds = 0;
  if (parts.take(':')) {
    second = parts.digits(2);
    if (parts.take('.') || parts.take(',')) nanoseconds = parts.fraction();
  }
  const minutes zone = read_zone(parts);
  if (!parts.ok() || !parts.at_end() || hour > 23 || minute > 59 || second > 59) return std::nullopt;
  if (zone >= hours(24) || zone <= -hours(24)) return std::nullopt;
  const std::chrono::year_month_day date(std::chrono::year(year), std::chrono::month(static_cast<unsigned>(month)),
                                         std::chrono::day(static_cast<unsigned>(day)));
  if (!date.ok()) return std::nullopt;
  const Duration within = hours(hour) + minutes(minute) + seconds(second) + Duration(nanoseconds);
  return stamp_on(std::chrono::sys_days(date), within - zone);
}

}  // namespace waymark::csv
