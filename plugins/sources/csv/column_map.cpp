// SPDX-License-Identifier: Apache-2.0
#include "column_map.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "number_text.hpp"
#include "waymark/config/nearest_name.hpp"
#include "waymark/config/source_config.hpp"

namespace waymark::csv {
namespace {

constexpr std::size_t kMostColumns = 1'000'000;

[[noreturn]] void reject(std::string_view field, const std::string& label, NumberText text) {
  switch (text) {
    case NumberText::empty:
      throw BadRow(label + " is empty, a number is expected");
    case NumberText::out_of_range:
      throw BadRow(in_quotes(field) + " in " + label + " is out of range");
    default:
      throw BadRow(in_quotes(field) + " in " + label + " is not a number");
  }
}

double finite_number(std::string_view field, const std::string& label) {
  double value = 0.0;
  const NumberText text = parse_number(field, value);
  if (text != NumberText::ok) reject(field, label, text);
  if (!std::isfinite(value)) throw BadRow(in_quotes(field) + " in " + label + " is not finite");
  return value;
}

/// The key `column` of a mapping that describes one.
Column read_column(const Config& settings, std::string_view field, ColumnFinder& finder) {
  return finder.find(settings, {"column", "a number, counted from 0, or a name from the header"}, field);
}

double non_zero_scale(const Config& config) {
  const double scale = config.number(
      {"scale", "value = raw · scale + offset: radians of degrees by 0.0174532925199433, metres of ticks"}, 1.0);
  if (scale == 0.0) config.fail("scale", "0 would make every value the same; a number other than 0 is expected");
  return scale;
}

double read_offset(const Config& config) { return config.number({"offset", "value = raw · scale + offset"}, 0.0); }

std::optional<int> power_of_ten(double value) {
  for (int exponent = -12; exponent <= 6; ++exponent) {
    const std::string text = "1e" + std::to_string(exponent);
    double power = 0.0;
    std::from_chars(text.data(), text.data() + text.size(), power);
    if (value == power) return exponent;
  }
  return std::nullopt;
}

}  // namespace

Column ColumnFinder::find(const Config& config, const Config::Key& key, std::string_view field) {
  return find(config, key.name, config.text(key), field);
}

Column ColumnFinder::find(const Config& config, std::string_view key, const std::string& name, std::string_view field) {
  std::size_t index = 0;
  const auto [stop, error] = std::from_chars(name.data(), name.data() + name.size(), index);
  const bool is_number = !name.empty() && error == std::errc{} && stop == name.data() + name.size();
  if (is_number) {
    if (index >= kMostColumns) config.fail(key, name + " is not a column number (0 to 999999)");
  } else {
    const auto found = std::ranges::find(header_, name);
    if (found == header_.end()) {
      if (header_.empty())
        config.fail(key, in_quotes(name) + " is not a column number, and the file has no header row");
      const std::vector<std::string_view> names(header_.begin(), header_.end());
      config.fail(key, "the header has no column " + in_quotes(name) + suggestion(name, names));
    }
    index = static_cast<std::size_t>(found - header_.begin());
  }
  use(index, 1, field);
  return {index, "column " + std::to_string(index) + " (" + std::string(field) + ")"};
}

void ColumnFinder::use(std::size_t first, std::size_t count, std::string_view field) {
  needed_ = std::max(needed_, first + count);
  used_.push_back(std::string(field) + "=" + std::to_string(first) + "+" + std::to_string(count));
}

std::string ColumnFinder::signature() const {
  std::vector<std::string> sorted = used_;
  std::ranges::sort(sorted);
  std::string result;
  for (const std::string& one : sorted) result += one + ";";
  return result;
}

NumberColumn::NumberColumn(const Config& columns, const Config::Key& key, ColumnFinder& finder)
    : may_be_empty_(finder.keeps_invalid()) {
  if (columns.is_mapping(key)) {
    const Config settings = columns.child(key);
    column_ = read_column(settings, key.name, finder);
    scale_ = non_zero_scale(settings);
    offset_ = read_offset(settings);
  } else {
    column_ = finder.find(columns, key, key.name);
  }
}

double NumberColumn::read(Row row) const {
  if (is_unknown(row)) return std::numeric_limits<double>::quiet_NaN();
  double value = finite_number(row[column_.index], column_.label) * scale_;
  if (offset_ != 0.0) value += offset_;  // -0 + 0 would lose its sign
  if (!std::isfinite(value)) throw BadRow(in_quotes(row[column_.index]) + " in " + column_.label + " is out of range");
  return value;
}

double NumberColumn::growth(double before, double after, double wraps_at) const {
  const double growth = after - before;
  return wraps_at > 0.0 ? std::remainder(growth, wraps_at * std::abs(scale_)) : growth;
}

int NumberColumn::read_integer(Row row) const {
  const double value = read(row);
  if (value != std::floor(value) || std::abs(value) > std::numeric_limits<int>::max()) {
    throw BadRow(in_quotes(row[column_.index]) + " in " + column_.label + " is not a whole number");
  }
  return static_cast<int>(value);
}

std::optional<NumberColumn> optional_number_column(const Config& columns, const Config::Key& key,
                                                   ColumnFinder& finder) {
  if (!columns.has(key)) return std::nullopt;
  NumberColumn column(columns, key, finder);
  if (finder.allows_empty()) column.allow_empty();
  return column;
}

ColumnRange::ColumnRange(const Config& columns, const Config::Key& key, ColumnFinder& finder) : field_(key.name) {
  const Config settings = columns.child(key);
  first_ = finder.find(settings, {"first", "first column: a number, counted from 0, or a name from the header"}, field_)
               .index;
  if (settings.has("count") == settings.has("last")) settings.fail("give either count or last");
  if (settings.has("count")) {
    const std::int64_t count = settings.integer({"count", "how many columns; instead of `last`"});
    if (count < 1 || count > static_cast<std::int64_t>(kMostColumns)) {
      settings.fail("count", std::to_string(count) + " is not a number of columns (1 to 1000000)");
    }
    count_ = static_cast<std::size_t>(count);
  } else {
    const std::size_t last = finder.find(settings, {"last", "last column; instead of `count`"}, field_).index;
    if (last < first_) settings.fail("last", "the last column lies before the first");
    count_ = last - first_ + 1;
  }
  finder.use(first_, count_, field_);
  scale_ = non_zero_scale(settings);
  offset_ = read_offset(settings);
}

std::string ColumnRange::label(std::size_t beam) const {
  return "column " + std::to_string(first_ + beam) + " (" + field_ + ", beam " + std::to_string(beam) + ")";
}

void ColumnRange::read(Row row, std::vector<float>& values, std::optional<float> non_finite) const {
  values.resize(count_);
  for (std::size_t i = 0; i < count_; ++i) {
    const std::string_view field = row[first_ + i];
    double raw = 0.0;
    const NumberText text = parse_number(field, raw);
    if (text != NumberText::ok) reject(field, label(i), text);
    values[i] = static_cast<float>(raw * scale_ + offset_);
    if (std::isfinite(values[i])) continue;
    if (!non_finite) {
      throw BadRow(in_quotes(field) + " in " + label(i) +
                   " is not finite; if it means no return, set scan.allow_non_finite");
    }
    values[i] = *non_finite;
  }
}

TimeColumn::TimeColumn(const Config& config, const Config::Key& key, ColumnFinder& finder) {
  if (!config.is_mapping(key)) {
    column_ = finder.find(config, key, key.name);
    exponent_ = 0;
    return;
  }
  const Config settings = config.child(key);
  column_ = read_column(settings, key.name, finder);
  scale_ = settings.positive({"scale",
                              "turns the column into seconds: `1e-3` for milliseconds, `1e-9` for nanoseconds; with a "
                              "power of ten every decimal digit is kept down to the nanosecond"},
                             1.0);
  exponent_ = power_of_ten(scale_);
  const std::string offset = settings.text({"offset_s", "s", "is added"}, "0");
  if (parse_nanoseconds(offset, 0, offset_ns_) != NumberText::ok) {
    settings.fail("offset_s", in_quotes(offset) + " is not a number of seconds");
  }
}

Time TimeColumn::read(Row row) const {
  const std::string_view field = row[column_.index];
  std::int64_t nanoseconds = 0;
  if (exponent_) {
    const NumberText text = parse_nanoseconds(field, *exponent_, nanoseconds);
    if (text != NumberText::ok) {
      finite_number(field, column_.label);  // names NaN and infinity as such
      reject(field, column_.label, text);
    }
  } else {
    const long double value = std::round(static_cast<long double>(finite_number(field, column_.label)) * scale_ * 1e9L);
    if (!(std::abs(value) < 9.2e18L)) reject(field, column_.label, NumberText::out_of_range);
    nanoseconds = static_cast<std::int64_t>(value);
  }
  const auto stamp = moved(Time{Duration{nanoseconds}}, Duration{offset_ns_});
  if (!stamp) reject(field, column_.label, NumberText::out_of_range);
  return *stamp;
}

RowFilter::RowFilter(const Config& config, ColumnFinder& finder) {
  const std::vector<Config> items = config.items_or_empty(
      {"where", "conditions that a row must satisfy, all of them; other rows are passed over without being bad"});
  for (const Config& item : items) {
    Condition condition;
    condition.column = read_column(item, "where", finder);
    if (item.has("equals"))
      condition.in = {item.number({"equals", "", "the number in the column; instead of `in`", "any"})};
    if (item.has("in")) {
      if (condition.in) item.fail("in", "give either equals or in");
      condition.in = item.numbers({"in", "", "the number in the column is one of these", "any"});
    }
    if (item.has("not_in"))
      condition.not_in = item.numbers({"not_in", "", "the number in the column is none of these", "none"});
    if (item.has("min")) condition.min = item.number({"min", "", "the number in the column is not below this", "none"});
    if (item.has("max")) condition.max = item.number({"max", "", "the number in the column is not above this", "none"});
    const bool says_something = condition.in || !condition.not_in.empty() || item.has("min") || item.has("max");
    if (!says_something) item.fail("a condition needs equals, in, not_in, min or max");

    signature_ += std::to_string(condition.column.index) + ":";
    if (condition.in) {
      for (const double value : *condition.in) signature_ += "=" + std::to_string(value);
    }
    for (const double value : condition.not_in) signature_ += "!" + std::to_string(value);
    signature_ += "[" + std::to_string(condition.min) + "," + std::to_string(condition.max) + "]";
    conditions_.push_back(std::move(condition));
  }
}

bool RowFilter::keeps(Row row) const {
  return std::ranges::all_of(conditions_, [row](const Condition& condition) {
    const double value = finite_number(row[condition.column.index], condition.column.label);
    return (!condition.in || std::ranges::find(*condition.in, value) != condition.in->end()) &&
           std::ranges::find(condition.not_in, value) == condition.not_in.end() && value >= condition.min &&
           value <= condition.max;
  });
}

std::string suggestion(std::string_view name, const std::vector<std::string_view>& names) {
  if (names.empty()) return "";
  std::vector<std::string_view> ranked = names;
  std::ranges::stable_sort(ranked, {}, [name](std::string_view other) { return edit_distance(name, other); });
  constexpr std::size_t kShown = 12;
  std::string result = "; did you mean " + in_quotes(ranked.front()) + "? (there ";
  result += names.size() == 1 ? "is " : "are ";
  for (std::size_t i = 0; i < std::min(names.size(), kShown); ++i) {
    if (i > 0) result += ", ";
    result += names[i];
  }
  return result + (names.size() > kShown ? ", …)" : ")");
}

void check_fields(const Config& columns, const std::vector<std::string_view>& valid,
                  const std::vector<std::string_view>& required, std::string_view owner) {
  for (const std::string& key : columns.keys()) {
    if (std::ranges::find(valid, key) == valid.end()) {
      columns.fail(key, std::string(owner) + " has no field " + in_quotes(key) + suggestion(key, valid));
    }
  }
  for (const std::string_view key : required) {
    if (!columns.has(key)) columns.fail(std::string(owner) + " needs the column " + in_quotes(key));
  }
}

std::filesystem::path text_file(const Config& config) {
  return readable_file(
      config, {"path", "plain text or gzip, recognised by content; relative paths count from the folder of the YAML"});
}

bool empty_is_unknown(const Config& config) {
  return config.boolean({"empty_is_unknown", "an empty field of an optional column is an unknown value, not a fault"},
                        false);
}

Format read_format(const Config& config) {
  Format format;
  if (config.has("delimiter")) {
    const std::string word = config.text(
        {"delimiter", "",
         "`\",\"`, `\";\"`, `\"|\"`, `\":\"`, `tab`, or `space` (runs of spaces and tabs count as one)", "guessed"});
    if (word == "tab" || word == "\t") {
      format.delimiter = '\t';
    } else if (word == "space" || word == " ") {
      format.delimiter = Format::kBlanks;
    } else if (word == "," || word == ";" || word == "|" || word == ":") {
      format.delimiter = word[0];
    } else {
      config.fail("delimiter",
                  in_quotes(word) + R"( is not a delimiter; one of "," ";" "|" ":" tab space is expected)");
    }
  }
  format.comment = config.text({"comment", "lines that start with it are skipped; `\"\"`: there are none"}, "#");
  if (config.has("header_rows")) {
    format.header_rows = static_cast<int>(config.integer_in(
        {"header_rows", "",
         "rows before the data, the first one names the columns; guessed: one if no field of the first row is a number",
         "guessed"},
        0, 1000, 0));
  }
  return format;
}

}  // namespace waymark::csv
