// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>

#include "config_node.hpp"

namespace waymark::config {
namespace {

/// Edits of one character, or swaps of two neighbours, that turn a into b (optimal string alignment).
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

bool is_unit(std::string_view word) {
  static constexpr std::array<std::string_view, 32> kUnits = {
      "m",  "cm", "mm",  "km",  "deg",  "rad",    "s",      "ms",      "us",      "ns",      "min",
      "h",  "hz", "khz", "per", "sqrt", "g",      "mps",    "kmh",     "tesla",   "percent", "ppm",
      "m2", "s2", "ut",  "nt",  "px",   "metres", "meters", "seconds", "degrees", "radians"};
  return std::find(kUnits.begin(), kUnits.end(), word) != kUnits.end();
}

/// The key without its unit: sigma_m_per_s → sigma.
std::string_view without_unit(std::string_view key) {
  for (;;) {
    const std::size_t bar = key.rfind('_');
    if (bar == std::string_view::npos || bar == 0 || !is_unit(key.substr(bar + 1))) return key;
    key = key.substr(0, bar);
  }
}

}  // namespace

std::string nearest(std::string_view word, const std::vector<std::string>& words) {
  std::size_t best = std::max<std::size_t>(2, word.size() / 3) + 1;
  std::string found;
  for (const std::string& candidate : words) {
    const std::size_t distance = edit_distance(word, candidate);
    // A word that shares nothing with another is not near, however short both are.
    if (distance < best && distance < std::max(word.size(), candidate.size())) {
      best = distance;
      found = candidate;
    }
  }
  return found;
}

std::string nearest_key(std::string_view key, const std::vector<std::string>& keys) {
  for (const std::string& candidate : keys) {
    if (candidate != key && without_unit(candidate) == without_unit(key)) return candidate;
  }
  return nearest(key, keys);
}

}  // namespace waymark::config
