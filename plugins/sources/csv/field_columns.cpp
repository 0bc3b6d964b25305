// SPDX-License-Identifier: Apache-2.0
#include "field_columns.hpp"

#include <algorithm>
#include <cmath>

#include "bad_row.hpp"
#include "number_text.hpp"

namespace waymark::csv {
namespace {

std::string listed(std::span<const std::string_view> words) {
  std::string list;
  for (const std::string_view word : words) list += (list.empty() ? "" : ", ") + std::string(word);
  return list;
}

/// The place of the word that `key` of `config` is. Throws ConfigError.
int place_of_word(const Config& config, const Config::Key& key, std::span<const std::string_view> words) {
  const std::string word = config.text(key);
  const auto found = std::ranges::find(words, word);
  if (found == words.end()) config.fail(key.name, in_quotes(word) + " is not one of: " + listed(words));
  return static_cast<int>(found - words.begin());
}

/// What the value is, for a message that says what it may be.
std::string limit_text(const FieldInfo& info) {
  const std::string_view quantity = info.name().substr(0, info.name().rfind('_'));  // without its unit
  const std::string limit = std::to_string(std::lround(info.limit));
  return " is not a " + std::string(quantity) + " (-" + limit + " to " + limit + " " + std::string(info.unit) + ")";
}

}  // namespace

void check_limit(Row row, const NumberColumn& column, const FieldInfo& info, double value) {
  if (info.limit == 0.0 || !(std::abs(value) > info.limit)) return;
  throw BadRow(column.text(row) + " in " + column.label() + limit_text(info));
}

void check_constant(const Config& columns, const NumberColumn& column, const FieldInfo& info) {
  if (!column.constant() || info.limit == 0.0 || !(std::abs(*column.constant()) > info.limit)) return;
  columns.fail(column.text({}) + limit_text(info));
}

std::optional<Eigen::Quaterniond> read_quaternion(Row row, const std::vector<NumberColumn>& wxyz,
                                                  const FieldInfo& info) {
  const Eigen::Quaterniond q(wxyz[0].read(row), wxyz[1].read(row), wxyz[2].read(row), wxyz[3].read(row));
  const double norm = q.norm();
  if (norm == 0.0 || q.coeffs().array().isNaN().all()) return std::nullopt;
  constexpr double kLoose = 0.01;
  constexpr double kTight = 1e-9;  // what was normalised once stays as it is, bit by bit
  if (!(std::abs(norm - 1.0) < kLoose)) {
    throw BadRow(std::string(info.names.front()) + " to " + std::string(info.names.back()) +
                 " are not a unit quaternion: their norm is " + std::to_string(norm));
  }
  return std::abs(norm - 1.0) < kTight ? q : q.normalized();
}

std::vector<NumberColumn> all_or_none(const Config& columns, const FieldInfo& info, std::string_view owner,
                                      ColumnFinder& finder) {
  std::vector<NumberColumn> found;
  const auto names =
      std::span(info.names)
          .first(static_cast<std::size_t>(std::ranges::find(info.names, std::string_view()) - info.names.begin()));
  FieldInfo described = info;
  const std::string meaning = std::string(info.meaning) + "; all " + std::to_string(names.size()) + " or none";
  described.meaning = meaning;
  for (const std::string_view name : names) {
    if (auto column = optional_number_column(columns, key_of(described, name), finder))
      found.push_back(std::move(*column));
  }
  if (found.empty() || found.size() == names.size()) return found;
  std::string list;
  std::size_t count = 0;
  for (const std::string_view name : names) {
    const bool last = ++count == names.size();
    list += (list.empty() ? "" : last ? " and " : ", ") + in_quotes(name);
  }
  columns.fail(std::string(owner) + " needs " + list + ", or none of them");
}

FlagColumn::FlagColumn(const Config& columns, const FieldInfo& info, ColumnFinder& finder) {
  const std::string meaning = std::string(info.meaning) + "; a column of 0 and 1, or `true` for all rows";
  const Config::Key key(info.name(), info.unit, meaning, "optional");
  const std::string word = columns.is_mapping(key) ? "" : columns.text(key);
  if (word == "true" || word == "false") {
    always_ = word == "true";
  } else {
    column_.emplace(columns, key, finder);
  }
}

bool FlagColumn::read(Row row) const {
  if (!column_) return always_;
  const double value = column_->read(row);
  if (value != 0.0 && value != 1.0) {
    throw BadRow(column_->text(row) + " in " + column_->label() + " is neither 0 nor 1");
  }
  return value == 1.0;
}

WordColumn::WordColumn(const Config& columns, const FieldInfo& info, ColumnFinder& finder) {
  if (!columns.is_mapping(info.name()))
    columns.fail(info.name(), "expected {column, map: {number: word}} or {constant: word}");
  const Config settings = columns.child(key_of(info, info.name()));
  const std::string meaning = "instead of a column: the word of all rows, one of " + listed(info.words);
  if (settings.has("constant")) {
    constant_ = place_of_word(settings, {"constant", meaning}, info.words);
    finder.note(std::string(info.name()) + "=" + std::to_string(*constant_));
    return;
  }
  column_.emplace(columns, key_of(info, info.name()), finder);
  const std::string map_meaning =
      "the word for each number, one of " + listed(info.words) + "; other numbers count as unknown";
  const Config map = settings.child({"map", map_meaning});
  for (const std::string& key : map.keys()) {
    double code = 0.0;
    if (parse_number(key, code) != NumberText::ok || code != std::floor(code) || std::abs(code) > 1e6) {
      map.fail(key, in_quotes(key) + " is not a whole number");
    }
    words_.emplace_back(static_cast<int>(code), place_of_word(map, key, info.words));
  }
}

std::optional<int> WordColumn::read(Row row) const {
  if (!column_) return constant_;
  const int code = column_->read_integer(row);
  std::optional<int> place;
  for (const auto& [number, word] : words_) {
    if (number == code) place = word;
  }
  return place;
}

}  // namespace waymark::csv
