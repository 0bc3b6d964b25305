// SPDX-License-Identifier: Apache-2.0
#include "row_filter.hpp"

#include <algorithm>
#include <cmath>

#include "bad_row.hpp"
#include "number_text.hpp"

namespace waymark::csv {

RowFilter::RowFilter(const Config& config, const ColumnFinder& finder) {
  // What a condition looks at does not count as needed by the rows that are passed over.
  ColumnFinder own = finder;
  const std::vector<Config> items = config.items_or_empty(
      {"where", "conditions that a row must satisfy, all of them; other rows are passed over without being bad"});
  for (const Config& item : items) {
    Condition condition = read_condition(item, own);
    signature_ += std::to_string(condition.column.index) + ":";
    if (condition.in) {
      for (const double value : condition.in->numbers) signature_ += "=" + std::to_string(value);
      for (const std::string& word : condition.in->words) signature_ += "=\"" + word + "\"";
    }
    for (const double value : condition.not_in.numbers) signature_ += "!" + std::to_string(value);
    for (const std::string& word : condition.not_in.words) signature_ += "!\"" + word + "\"";
    signature_ += "[" + std::to_string(condition.min) + "," + std::to_string(condition.max) + "]";
    conditions_.push_back(std::move(condition));
  }
}

RowFilter::Values RowFilter::read_values(const std::vector<std::string>& words) {
  Values values;
  for (const std::string& word : words) {
    double number = 0.0;
    if (parse_number(word, number) != NumberText::ok || !std::isfinite(number)) {
      values.words = words;
      values.numbers.clear();
      return values;
    }
    values.numbers.push_back(number);
  }
  return values;
}

RowFilter::Condition RowFilter::read_condition(const Config& item, ColumnFinder& finder) {
  Condition condition;
  condition.column = finder.find(item, {"column", "a number, counted from 0, or a name from the header"}, "where");
  if (item.has("equals"))
    condition.in = read_values({item.text({"equals", "", "the number or text in the column; instead of `in`", "any"})});
  if (item.has("in")) {
    if (condition.in) item.fail("in", "give either equals or in");
    condition.in = read_values(item.texts({"in", "", "what is in the column is one of these numbers or texts", "any"}));
  }
  if (item.has("not_in")) {
    condition.not_in =
        read_values(item.texts({"not_in", "", "what is in the column is none of these numbers or texts", "none"}));
  }
  const bool is_limited = item.has("min") || item.has("max");
  if (item.has("min")) condition.min = item.number({"min", "", "the number in the column is not below this", "none"});
  if (item.has("max")) condition.max = item.number({"max", "", "the number in the column is not above this", "none"});
  const bool compares_numbers = (condition.in && !condition.in->numbers.empty()) || !condition.not_in.numbers.empty();
  condition.needs_number = is_limited || compares_numbers;
  const bool says_something =
      condition.in || !condition.not_in.words.empty() || !condition.not_in.numbers.empty() || is_limited;
  if (!says_something) item.fail("a condition needs equals, in, not_in, min or max");
  return condition;
}

bool RowFilter::Values::hold(std::string_view field, double number) const {
  return std::ranges::find(numbers, number) != numbers.end() || std::ranges::find(words, field) != words.end();
}

bool RowFilter::Condition::keeps(std::string_view field) const {
  const double number = needs_number ? finite_number(field, column.label) : std::numeric_limits<double>::quiet_NaN();
  if ((in && !in->hold(field, number)) || not_in.hold(field, number)) return false;
  return !needs_number || (number >= min && number <= max);
}

bool RowFilter::keeps(Row row) const {
  for (const Condition& condition : conditions_) {
    if (row.size() <= condition.column.index) {
      throw BadRow("too few columns: " + std::to_string(row.size()) + ", at least " +
                   std::to_string(condition.column.index + 1) + " are expected by `where`");
    }
    if (!condition.keeps(row[condition.column.index])) return false;
  }
  return true;
}

}  // namespace waymark::csv
