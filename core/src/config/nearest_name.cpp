// SPDX-License-Identifier: Apache-2.0
#include "waymark/config/nearest_name.hpp"

#include <algorithm>
#include <string_view>
#include <vector>

namespace waymark {

namespace {

/// The words between the underscores, in alphabetical order.
std::vector<std::string_view> sorted_words(std::string_view name) {
  std::vector<std::string_view> words;
  for (std::size_t end = 0; end != std::string_view::npos;) {
    end = name.find('_');
    words.push_back(name.substr(0, end));
    name.remove_prefix(end == std::string_view::npos ? 0 : end + 1);
  }
  std::ranges::sort(words);
  return words;
}

}  // namespace

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before_last(b.size() + 1);
  std::vector<std::size_t> last(b.size() + 1);
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        row[j] = std::min(row[j], before_last[j - 2] + 1);
    }
    std::swap(before_last, last);
    std::swap(last, row);
  }
  return last[b.size()];
}

std::string nearest_name(std::string_view asked, const std::vector<std::string>& names) {
  std::size_t best = std::max<std::size_t>(2, asked.size() / 3) + 1;
  std::string found;
  for (const std::string& candidate : names) {
    // `vertical_sigma_m` for `sigma_vertical_m`.
    if (asked.size() == candidate.size() && asked != candidate && sorted_words(asked) == sorted_words(candidate))
      return candidate;
    const auto [shorter, longer] = std::minmax({asked.size(), candidate.size()});
    if (longer - shorter >= best) continue;  // at least so many edits
    const std::size_t distance = edit_distance(asked, candidate);
    // A word that shares nothing with another is not near, however short both are.
    if (distance < best && distance < std::max(asked.size(), candidate.size())) {
      best = distance;
      found = candidate;
    }
  }
  return found;
}

}  // namespace waymark
