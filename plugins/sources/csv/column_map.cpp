// SPDX-License-Identifier: Apache-2.0
#include "column_map.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "bad_row.hpp"
#include "number_text.hpp"
#include "units.hpp"
#include "waymark/config/nearest_name.hpp"
#include "waymark/config/source_config.hpp"

namespace waymark::csv {
namespace {

constexpr std::size_t kMostColumns = 1'000'000;

/// The key `column` of a mapping that describes one.
Column read_column(const Config& settings, std::string_view field, ColumnFinder& finder) {
  return finder.find(settings, {"column", "a number, counted from 0, or a name from the header"}, field);
}

/// For messages: `column "v"`, or by its number if the header does not name it, or names two the same.
std::string place(const std::vector<std::string>& header, std::size_t index) {
  const bool is_named =
      index < header.size() && !header[index].empty() && std::ranges::count(header, header[index]) == 1;
  return is_named ? "column " + in_quotes(header[index]) : "column " + std::to_string(index) + " counted from 0";
}

double non_zero_scale(const Config& config) {
  const double scale = config.number(
      {"scale", "value = raw · scale + offset: radians of degrees by 0.0174532925199433, metres of ticks"}, 1.0);
  if (scale == 0.0) config.fail("scale", "0 would make every value the same; a number other than 0 is expected");
  return scale;
}

Config::Key unit_key() {
  return {"unit", "", "of value = raw · scale + offset, which is then converted: deg/s, mm, km/h", "the field's"};
}

/// Throws ConfigError if the key does not state a unit.
void require_unit(const Config& columns, const GivenKey& given, const Config::Key& key) {
  if (given.states_unit) return;
  columns.fail(given.key, "its unit is missing: " + std::string(key.name) + ", or { column: …, unit: " +
                              std::string(key.unit) + " }, with one of " + units_like(key.unit));
}

double read_offset(const Config& config) { return config.number({"offset", "value = raw · scale + offset"}, 0.0); }

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
    const auto found = std::ranges::find(*header_, name);
    if (found == header_->end()) {
      if (header_->empty())
        config.fail(key, in_quotes(name) + " is not a column number, and the file has no header row");
      const std::vector<std::string_view> names(header_->begin(), header_->end());
      config.fail(key, "the header has no column " + in_quotes(name) + suggestion(name, names));
    }
    index = static_cast<std::size_t>(found - header_->begin());
  }
  use(index, 1, field);
  return {index, place(*header_, index) + " (" + std::string(field) + ")"};
}

void ColumnFinder::use(std::size_t first, std::size_t count, std::string_view field) {
  needed_ = std::max(needed_, first + count);
  used_.push_back(std::string(field) + "=" + std::to_string(first) + "+" + std::to_string(count));
}

void ColumnFinder::note(std::string what) { used_.push_back(std::move(what)); }

std::string ColumnFinder::signature() const {
  std::vector<std::string> sorted = used_;
  std::ranges::sort(sorted);
  std::string result;
  for (const std::string& one : sorted) result += one + ";";
  return result;
}

NumberColumn::NumberColumn(const Config& columns, const Config::Key& key, ColumnFinder& finder)
    : may_be_empty_(finder.keeps_invalid()) {
  const GivenKey given = given_key(columns, {key.name, key.unit}).value_or(GivenKey{std::string(key.name)});
  const Config::Key used(given.key, key.unit, key.meaning, key.fallback);
  double factor = given.factor;
  if (columns.is_mapping(used)) {
    const Config settings = columns.child(used);
    if (settings.has("constant")) {
      constant_ = settings.number({"constant", "the value of all rows, instead of a column"});
    } else {
      column_ = read_column(settings, given.key, finder);
      scale_ = non_zero_scale(settings);
      offset_ = read_offset(settings);
    }
    if (settings.has("unit")) {
      if (given.states_unit && !given.is_own_name) settings.fail("unit", given.key + " names the unit already");
      factor = unit_factor(settings, unit_key(), key.unit);
    } else {
      require_unit(columns, given, key);
    }
  } else {
    require_unit(columns, given, key);
    column_ = finder.find(columns, used, given.key);
  }
  scale_ *= factor;
  offset_ *= factor;
  if (constant_) {
    constant_ = *constant_ * factor;
    column_.label = "the constant " + given.key;
    finder.note(given.key + "=" + std::to_string(*constant_));
  }
  is_plain_ = !constant_ && !may_be_empty_;
}

std::string NumberColumn::text(Row row) const {
  if (!constant_) return in_quotes(row[column_.index]);
  std::string number = std::to_string(*constant_);
  number.erase(number.find_last_not_of('0') + 1);
  if (number.back() == '.') number.pop_back();
  return number;
}

double NumberColumn::read(Row row) const {
  if (!is_plain_) {
    if (constant_) return *constant_;
    if (is_unknown(row)) return std::numeric_limits<double>::quiet_NaN();
  }
  double value = finite_number(row[column_.index], column_.label) * scale_;
  if (offset_ != 0.0) value += offset_;  // -0 + 0 would lose its sign
  if (!std::isfinite(value)) throw BadRow(text(row) + " in " + column_.label + " is out of range");
  return value;
}

double NumberColumn::read_any(Row row) const {
  if (constant_) return *constant_;
  double value = 0.0;
  const NumberText text = parse_number(row[column_.index], value);
  if (text != NumberText::ok) reject(row[column_.index], column_.label, text);
  return value * scale_ + offset_;
}

double NumberColumn::growth(double before, double after, double wraps_at) const {
  const double growth = after - before;
  return wraps_at > 0.0 ? std::remainder(growth, wraps_at * std::abs(scale_)) : growth;
}

int NumberColumn::read_integer(Row row) const {
  const double value = read(row);
  if (value != std::floor(value) || std::abs(value) > std::numeric_limits<int>::max()) {
    throw BadRow(text(row) + " in " + column_.label + " is not a whole number");
  }
  return static_cast<int>(value);
}

std::optional<NumberColumn> optional_number_column(const Config& columns, const Config::Key& key,
                                                   ColumnFinder& finder) {
  if (!columns.has(key) && !given_key(columns, {key.name, key.unit})) return std::nullopt;
  NumberColumn column(columns, key, finder);
  if (finder.allows_empty()) column.allow_empty();
  return column;
}

ColumnRange::ColumnRange(const Config& columns, const Config::Key& key, ColumnFinder& finder)
    : header_(finder.header()) {
  const GivenKey given = given_key(columns, {key.name, key.unit}).value_or(GivenKey{std::string(key.name)});
  field_ = given.key;
  const Config settings = columns.child(Config::Key(given.key, key.unit, key.meaning, key.fallback));
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
  double factor = given.factor;
  if (settings.has("unit")) {
    if (given.states_unit && !given.is_own_name) settings.fail("unit", given.key + " names the unit already");
    factor = unit_factor(settings, unit_key(), key.unit);
  } else {
    require_unit(columns, given, key);
  }
  scale_ = factor * non_zero_scale(settings);
  offset_ = factor * read_offset(settings);
}

std::string ColumnRange::label(std::size_t beam) const {
  return place(*header_, first_ + beam) + " (" + field_ + ", beam " + std::to_string(beam) + ")";
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

void check_fields(const Config& columns, const std::vector<FieldName>& valid,
                  const std::vector<std::string_view>& required, std::string_view owner) {
  std::vector<std::string_view> names;
  names.reserve(valid.size());
  for (const FieldName& field : valid) names.push_back(field.name);
  for (const std::string& key : columns.keys()) {
    if (std::ranges::any_of(valid, [&](const FieldName& field) { return names_field(key, field); })) continue;
    columns.fail(key, std::string(owner) + " has no field " + in_quotes(key) + suggestion(key, names));
  }
  for (const FieldName& field : valid) {
    // `has` lets the reference pages know of the key.
    if (std::ranges::find(required, field.name) == required.end() || columns.has(field.name)) continue;
    if (given_key(columns, field)) continue;
    const bool may_be_constant = !field.unit.empty() && field.name != "time";
    columns.fail(std::string(owner) + " needs the column " + in_quotes(field.name) +
                 (may_be_constant ? ", or { constant: … } where the file has none" : ""));
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
  if (config.has("records")) {
    format.records = RecordLayout::read(
        config.child({"records", "the file is binary: records of one length, little-endian; columns are numbers"}));
    for (const std::string_view key : {"delimiter", "comment", "header_rows"})
      if (config.has(key)) config.fail(key, "is of text files; this one has records");
    return format;
  }
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
