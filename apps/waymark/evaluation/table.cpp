// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/evaluation/table.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <system_error>

#include "waymark/base/error.hpp"

namespace waymark::evaluation {
namespace {

constexpr std::string_view kBlanks = " \t\r";

std::string_view trim(std::string_view text) {
  const auto first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

std::optional<double> to_number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::vector<std::string> split(std::string_view line, char separator) {
  std::vector<std::string> fields;
  if (separator == ' ') {
    while (true) {
      const auto first = line.find_first_not_of(kBlanks);
      if (first == std::string_view::npos) return fields;
      line.remove_prefix(first);
      const auto end = std::min(line.find_first_of(kBlanks), line.size());
      fields.emplace_back(line.substr(0, end));
      line.remove_prefix(end);
    }
  }
  while (true) {
    const auto end = line.find(separator);
    std::string_view field = trim(line.substr(0, end));
    if (field.size() >= 2 && field.front() == '"' && field.back() == '"') field = field.substr(1, field.size() - 2);
    fields.emplace_back(field);
    if (end == std::string_view::npos) return fields;
    line.remove_prefix(end + 1);
  }
}

// zlib reads a file that is not compressed as it is, so both kinds take the same way.
std::string read_text(const std::filesystem::path& file) {
  if (std::error_code error; !std::filesystem::is_regular_file(file, error)) {
    throw DataError(fmt::format("{}: not found, or not a file", file.string()));
  }
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> stream(gzopen(file.c_str(), "rb"), &gzclose);
  if (stream == nullptr) throw DataError(fmt::format("{}: cannot be opened", file.string()));
  std::string text;
  std::array<char, 1 << 16> buffer;
  while (true) {
    const int count = gzread(stream.get(), buffer.data(), static_cast<unsigned>(buffer.size()));
    int code = Z_OK;
    const char* message = gzerror(stream.get(), &code);
    if (count < 0 || (code != Z_OK && code != Z_STREAM_END)) {
      throw DataError(fmt::format("{}: cannot be read: {}", file.string(), message));
    }
    if (count == 0) return text;
    text.append(buffer.data(), static_cast<std::size_t>(count));
  }
}

}  // namespace

Columns parse_columns(std::string_view text, const std::vector<std::string>& allowed) {
  Columns columns;
  for (const std::string& item : split(text, ',')) {
    const auto equals = item.find('=');
    const std::string name = item.substr(0, equals);
    int index = -1;
    if (equals != std::string::npos) {
      const char* end = item.data() + item.size();
      const auto result = std::from_chars(item.data() + equals + 1, end, index);
      if (result.ec != std::errc{} || result.ptr != end) index = -1;
    }
    if (index < 0) {
      throw Error(fmt::format("columns \"{}\": \"{}\" is not of the form name=index with an index from 0", text, item));
    }
    if (std::find(allowed.begin(), allowed.end(), name) == allowed.end()) {
      throw Error(fmt::format("columns \"{}\": unknown name \"{}\"; known: {}", text, name, fmt::join(allowed, ", ")));
    }
    if (!columns.emplace(name, index).second) {
      throw Error(fmt::format("columns \"{}\": \"{}\" is given twice", text, name));
    }
  }
  return columns;
}

Table::Table(const std::filesystem::path& file) : file_(file) {
  const std::string text = read_text(file);
  std::string_view rest = text;
  for (std::size_t line_number = 1; !rest.empty(); ++line_number) {
    const auto end = rest.find('\n');
    const std::string_view line = trim(rest.substr(0, end));
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
    if (line.empty() || line.front() == '#') continue;
    if (rows_.empty()) {
      separator_ = line.find(',') != std::string_view::npos   ? ','
                   : line.find(';') != std::string_view::npos ? ';'
                                                              : ' ';
    }
    rows_.push_back({line_number, split(line, separator_)});
  }
  if (rows_.empty()) throw DataError(fmt::format("{}: holds no row of data", file_.string()));
}

bool Table::starts_with_names(const std::vector<std::string_view>& names) const {
  const auto& fields = rows_.front().fields;
  const auto is_text = [](const std::string& field) { return !to_number(field); };
  return std::all_of(fields.begin(), fields.end(), is_text) ||
         std::any_of(fields.begin(), fields.end(), [&](const std::string& field) {
           return is_text(field) && std::find(names.begin(), names.end(), field) != names.end();
         });
}

void Table::drop_first_row() {
  rows_.erase(rows_.begin());
  if (rows_.empty()) throw DataError(fmt::format("{}: holds column names but no row of data", file_.string()));
}

const std::string& Table::field(std::size_t row, int column) const {
  const auto& fields = rows_[row].fields;
  if (static_cast<std::size_t>(column) >= fields.size()) {
    throw DataError(fmt::format("{}: {} fields, expected at least {}", place(row), fields.size(),
                                static_cast<std::size_t>(column) + 1));
  }
  return fields[static_cast<std::size_t>(column)];
}

double Table::number(std::size_t row, int column, std::string_view name) const {
  const std::string& text = field(row, column);
  const auto value = to_number(text);
  if (!value || !std::isfinite(*value)) {
    throw DataError(fmt::format("{}: {} is \"{}\", expected a finite number", place(row), name, text));
  }
  return *value;
}

Time Table::time(std::size_t row, int column, std::string_view name) const {
  const std::string& text = field(row, column);
  try {
    return parse_time(text);
  } catch (const Error&) {
    throw DataError(fmt::format("{}: {} is \"{}\", expected decimal seconds", place(row), name, text));
  }
}

double Table::number_or_nan(std::size_t row, int column) const {
  const auto& fields = rows_[row].fields;
  if (static_cast<std::size_t>(column) >= fields.size()) return std::numeric_limits<double>::quiet_NaN();
  const auto value = to_number(fields[static_cast<std::size_t>(column)]);
  return value && std::isfinite(*value) ? *value : std::numeric_limits<double>::quiet_NaN();
}

std::string Table::place(std::size_t row) const { return fmt::format("{}:{}", file_.string(), rows_[row].line); }

}  // namespace waymark::evaluation
