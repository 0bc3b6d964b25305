// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>

#include "apps/waymark/import/point_file.hpp"
#include "plugins/shared/cloud_file/cloud_layout.hpp"
#include "waymark/base/error.hpp"

namespace waymark::imports {
namespace {

constexpr std::string_view kBlanks = " \t\r";

std::optional<double> number_in(std::string_view word) {
  double value = 0.0;
  if (word.starts_with('+')) word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc{} && end == word.data() + word.size() ? std::optional(value) : std::nullopt;
}

char delimiter_of(std::string_view line) {
  for (const char c : {',', ';', '\t'}) {
    if (line.find(c) != std::string_view::npos) return c;
  }
  return ' ';
}

void split(std::string_view line, char delimiter, std::vector<std::string_view>& words) {
  words.clear();
  if (delimiter == ' ') {
    while (true) {
      line.remove_prefix(std::min(line.find_first_not_of(kBlanks), line.size()));
      if (line.empty()) return;
      words.push_back(line.substr(0, line.find_first_of(kBlanks)));
      line.remove_prefix(words.back().size());
    }
  }
  while (true) {
    const std::size_t end = std::min(line.find(delimiter), line.size());
    std::string_view word = line.substr(0, end);
    word.remove_prefix(std::min(word.find_first_not_of(" \r\""), word.size()));
    word = word.substr(0, word.find_last_not_of(" \r\"") + 1);
    words.push_back(word);
    if (end == line.size()) return;
    line.remove_prefix(end + 1);
  }
}

/// Columns that are taken: 0-based; -1 if there is none.
struct TableColumns {
  std::array<int, 3> xyz{0, 1, 2};
  int intensity = -1;
  int time = -1;
  bool nanoseconds = false;
  std::size_t needed = 3;  ///< columns of each line
};

std::string lower(std::string_view word) {
  std::string text(word.substr(0, 40));
  std::ranges::transform(text, text.begin(),
                         [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
  return text;
}

TableColumns columns_of(const std::vector<std::string_view>& header, const std::string& place) {
  TableColumns columns;
  columns.xyz = {-1, -1, -1};
  for (std::size_t i = 0; i < header.size(); ++i) {
    std::string name = lower(header[i]);
    if (name.starts_with("//")) name.erase(0, 2);
    const auto index = static_cast<int>(i);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::string_view letter = std::string_view("xyz").substr(axis, 1);
      if (name == letter || name == std::string(letter).append("_m")) columns.xyz.at(axis) = index;
    }
    if (name == "intensity") columns.intensity = index;
    const bool in_nanoseconds = name == "offset_time" || name.ends_with("_ns");
    if (in_nanoseconds && name.ends_with("_ns")) name.resize(name.size() - 3);
    if (name.ends_with("_s")) name.resize(name.size() - 2);
    if (columns.time < 0 && is_time_of_point(name)) {
      columns.time = index;
      columns.nanoseconds = in_nanoseconds;
    }
  }
  if (std::ranges::any_of(columns.xyz, [](int i) { return i < 0; }))
    throw DataError(place + ": the header has no columns x, y and z");
  const int last = std::max({*std::ranges::max_element(columns.xyz), columns.intensity, columns.time});
  columns.needed = static_cast<std::size_t>(last) + 1;
  return columns;
}

}  // namespace

PointFile read_point_table(std::string_view content, const std::string& name, Time stamp) {
  PointFile file;
  std::optional<TableColumns> columns;
  char delimiter = ',';
  std::vector<std::string_view> words;
  std::size_t line_number = 0;
  for (std::size_t at = 0; at < content.size();) {
    const std::size_t end = std::min(content.find('\n', at), content.size());
    const std::string_view line = content.substr(at, end - at);
    at = end + 1;
    ++line_number;
    if (line.find_first_not_of(kBlanks) == std::string_view::npos || line.starts_with('#')) continue;
    const auto fail = [&](const std::string& problem) {
      throw DataError(fmt::format("{}:{}: {}", name, line_number, problem));
    };
    if (!columns) delimiter = delimiter_of(line);
    split(line, delimiter, words);
    if (!columns) {
      const bool is_header =
          std::ranges::none_of(words, [](std::string_view word) { return number_in(word).has_value(); });
      columns = is_header ? columns_of(words, fmt::format("{}:{}", name, line_number)) : TableColumns{};
      if (is_header) continue;
    }
    if (words.size() < columns->needed)
      fail(fmt::format("{} columns; at least {} are expected", words.size(), columns->needed));
    const auto number = [&](int column) {
      const std::string_view word = words[static_cast<std::size_t>(column)];
      const auto value = number_in(word);
      if (!value) fail(fmt::format("\"{}\" is no number", word.substr(0, 40)));
      return *value;
    };
    if (file.cloud.points_m.size() == cloud_file::kMostPoints)
      fail(fmt::format("more than {} points", cloud_file::kMostPoints));
    Eigen::Vector3f p;
    for (int axis = 0; axis < 3; ++axis)
      p[axis] = static_cast<float>(number(columns->xyz.at(static_cast<std::size_t>(axis))));
    PointCollector(file, columns->intensity >= 0, columns->time >= 0)
        .add(p, columns->intensity >= 0 ? number(columns->intensity) : 0.0,
             columns->time >= 0 ? seconds_after(stamp, number(columns->time), columns->nanoseconds) : 0.0);
  }
  if (!columns) throw DataError(name + ": holds no line with a point");
  return file;
}

}  // namespace waymark::imports
