// SPDX-License-Identifier: Apache-2.0
#include "time_column.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <string>

#include "bad_row.hpp"
#include "iso_time.hpp"
#include "number_text.hpp"
#include "units.hpp"

namespace waymark::csv {
namespace {

constexpr int kNano = -9;

std::optional<int> power_of_ten(double value) {
  for (int exponent = -12; exponent <= 6; ++exponent) {
    const std::string text = "1e" + std::to_string(exponent);
    double power = 0.0;
    std::from_chars(text.data(), text.data() + text.size(), power);
    if (value == power) return exponent;
  }
  return std::nullopt;
}

/// Of seconds since 1970.
bool is_in_this_century(double seconds) {
  constexpr double kFrom = 946'684'800.0;     // 2000-01-01
  constexpr double kUntil = 4'102'444'800.0;  // 2100-01-01
  return seconds >= kFrom && seconds < kUntil;
}

/// The unit in which a number of seconds that no calendar has is a time of this century; empty if there is none.
std::string_view likely_unit(double value) {
  struct Candidate {
    std::string_view unit;
    double seconds;
  };
  constexpr std::array kCandidates{Candidate{"ms", 1e-3}, Candidate{"us", 1e-6}, Candidate{"ns", 1e-9}};
  for (const auto& [unit, seconds] : kCandidates) {
    if (is_in_this_century(value * seconds)) return unit;
  }
  return {};
}

}  // namespace

TimeColumn::TimeColumn(const Config& config, const Config::Key& key, ColumnFinder& finder) {
  const auto given = given_key(config, {key.name, "s"});
  const Config::Key used(given ? std::string_view(given->key) : key.name, key.unit, key.meaning, key.fallback);
  if (given && given->factor != 1.0) {
    scale_ = given->factor;
    is_plain_ = false;
  }
  if (config.is_mapping(used)) {
    const Config settings = config.child(used);
    column_ = finder.find(settings, {"column", "a number, counted from 0, or a name from the header"}, key.name);
    if (settings.has("unit")) {
      if (!given->is_own_name) settings.fail("unit", given->key + " names the unit already");
      if (settings.has("scale")) settings.fail("unit", "give either unit or scale");
      scale_ = unit_factor(settings, {"unit", "", "of the column: s, ms, us or ns", "s"}, "s");
      is_plain_ = false;
    } else if (settings.has("scale")) {
      if (!given->is_own_name) settings.fail("scale", given->key + " names the unit already");
      scale_ = settings.positive(
          {"scale", "seconds = column · scale; with a power of ten every decimal digit is kept down to the nanosecond"},
          1.0);
      is_plain_ = false;
    }
    const std::string offset = settings.text({"offset_s", "s", "is added"}, "0");
    if (parse_nanoseconds(offset, 0, offset_ns_) != NumberText::ok) {
      settings.fail("offset_s", in_quotes(offset) + " is not a number of seconds");
    }
  } else {
    column_ = finder.find(config, used, key.name);
  }
  exponent_ = power_of_ten(scale_);
}

Time TimeColumn::read(Row row) const {
  const std::string_view field = row[column_.index];
  const auto stamp = moved(Time{Duration{nanoseconds(field)}}, Duration{offset_ns_});
  if (!stamp) reject_time(field, NumberText::out_of_range);
  return *stamp;
}

std::int64_t TimeColumn::nanoseconds(std::string_view field) const {
  std::int64_t nanoseconds = 0;
  if (exponent_) {
    const NumberText text = parse_nanoseconds(field, *exponent_, nanoseconds);
    if (text == NumberText::ok) {
      if (*exponent_ == kNano) refuse_seconds(field);
      return nanoseconds;
    }
    if (text == NumberText::not_a_number && looks_like_a_date(field)) {
      if (!is_plain_) throw BadRow(in_quotes(field) + " in " + column_.label + " is a date: it has no unit or scale");
      if (const auto stamp = parse_iso_time(field)) return stamp->time_since_epoch().count();
      throw BadRow(in_quotes(field) + " in " + column_.label +
                   " is not a date and time of ISO 8601, such as 2024-05-01T12:30:00.25Z");
    }
    reject_time(field, text);
  }
  const long double value = std::round(static_cast<long double>(finite_number(field, column_.label)) * scale_ * 1e9L);
  if (!(std::abs(value) < 9.2e18L)) reject_time(field, NumberText::out_of_range);
  return static_cast<std::int64_t>(value);
}

/// As nanoseconds. A log that begins at 0 has such values in its first seconds, too, but no digits after the point.
void TimeColumn::refuse_seconds(std::string_view field) const {
  if (field.find('.') == std::string_view::npos) return;
  const double value = finite_number(field, column_.label);
  if (value == std::floor(value) || !is_in_this_century(value)) return;
  const std::string tenths = std::to_string(std::lround(value * 1e-8));
  throw BadRow(in_quotes(field) + " in " + column_.label + " is " + tenths.substr(0, tenths.size() - 1) + "." +
               tenths.back() +
               " s after 1970 as ns; as s since 1970 it lies in this century: time: { column, unit: s }");
}

void TimeColumn::reject_time(std::string_view field, NumberText text) const {
  const double value = finite_number(field, column_.label);  // names NaN and infinity as such
  const std::string_view unit = is_plain_ ? likely_unit(value) : std::string_view();
  if (text == NumberText::out_of_range && !unit.empty()) {
    throw BadRow(in_quotes(field) + " in " + column_.label + " is out of range as seconds; as " + std::string(unit) +
                 " since 1970 it lies in this century: { column, unit: " + std::string(unit) + " }");
  }
  reject(field, column_.label, text);
}

}  // namespace waymark::csv
