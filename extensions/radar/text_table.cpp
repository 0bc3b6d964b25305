// SPDX-License-Identifier: Apache-2.0
#include "text_table.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>

#include "waymark/base/error.hpp"

namespace waymark::radar {

TextTable::TextTable(std::unique_ptr<BytesFile> file, std::vector<std::string_view> columns)
    : file_(std::move(file)), columns_(std::move(columns)) {
  if (file_->line(text_)) ++row_;
  split();
  at_.reserve(columns_.size());
  for (const std::string_view column : columns_) {
    const auto found = std::ranges::find(fields_, column);
    if (found == fields_.end()) {
      throw DataError(place() + ": the first row names no column \"" + std::string(column) + "\"");
    }
    at_.push_back(static_cast<std::size_t>(std::distance(fields_.begin(), found)));
  }
}

void TextTable::split() {
  fields_.clear();
  std::string_view rest = text_;
  for (;;) {
    const std::size_t comma = rest.find(',');
    fields_.push_back(rest.substr(0, comma));
    if (comma == std::string_view::npos) return;
    rest.remove_prefix(comma + 1);
  }
}

bool TextTable::next() {
  if (!file_->line(text_)) return false;
  ++row_;
  split();
  const std::size_t most = *std::ranges::max_element(at_);
  if (fields_.size() > most) return true;
  throw DataError(place() + ": columns: " + std::to_string(fields_.size()) + "; at least " + std::to_string(most + 1) +
                  " are expected");
}

double TextTable::number(std::size_t column) const {
  const std::string_view field = fields_[at_[column]];
  double value = 0.0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (error == std::errc{} && end == field.data() + field.size() && std::isfinite(value)) return value;
  throw DataError(place() + ": " + std::string(columns_[column]) + ": \"" + std::string(field) + "\" is not a number");
}

Time TextTable::time(std::size_t column) const {
  try {
    return parse_time(fields_[at_[column]]);
  } catch (const DataError& error) {
    throw DataError(place() + ": " + std::string(columns_[column]) + ": " + error.what());
  }
}

}  // namespace waymark::radar
