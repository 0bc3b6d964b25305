// SPDX-License-Identifier: Apache-2.0
#include "field_columns.hpp"

#include <algorithm>
#include <cmath>

#include "number_text.hpp"

namespace waymark::csv {
namespace {

std::string listed(std::span<const std::string_view> words) {
  std::string list;
  for (const std::string_view word : words) list += (list.empty() ? "" : ", ") + std::string(word);
  return list;
}

const Config& with_map(const Config& columns, std::string_view key) {
  if (!columns.is_mapping(key)) columns.fail(key, "expected {column, map: {number: word}}");
  return columns;
}

}  // namespace

void check_limit(Row row, const Column& column, const FieldInfo& info, double value) {
  if (info.limit == 0.0 || !(std::abs(value) > info.limit)) return;
  const std::string_view quantity = info.name().substr(0, info.name().rfind('_'));  // without its unit
  const std::string limit = std::to_string(std::lround(info.limit));
  throw BadRow(in_quotes(row[column.index]) + " in " + column.label + " is not a " + std::string(quantity) + " (-" +
               limit + " to " + limit + " " + std::string(info.unit) + ")");
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
    const Column& column = column_->column();
    throw BadRow(in_quotes(row[column.index]) + " in " + column.label + " is neither 0 nor 1");
  }
  return value == 1.0;
}

WordColumn::WordColumn(const Config& columns, const FieldInfo& info, ColumnFinder& finder)
    : column_(with_map(columns, info.name()), key_of(info, info.name()), finder) {
  const std::string meaning =
      "the word for each number, one of " + listed(info.words) + "; other numbers count as unknown";
  const Config map = columns.child(info.name()).child({"map", meaning});
  for (const std::string& key : map.keys()) {
    double code = 0.0;
    if (parse_number(key, code) != NumberText::ok || code != std::floor(code) || std::abs(code) > 1e6) {
      map.fail(key, in_quotes(key) + " is not a whole number");
    }
    const std::string word = map.text(key);
    const auto found = std::ranges::find(info.words, word);
    if (found == info.words.end()) map.fail(key, in_quotes(word) + " is not one of: " + listed(info.words));
    words_.emplace_back(static_cast<int>(code), static_cast<int>(found - info.words.begin()));
  }
}

std::optional<int> WordColumn::read(Row row) const {
  const int code = column_.read_integer(row);
  std::optional<int> place;
  for (const auto& [number, word] : words_) {
    if (number == code) place = word;
  }
  return place;
}

}  // namespace waymark::csv
