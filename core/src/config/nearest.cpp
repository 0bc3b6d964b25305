// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>

#include "config/node.hpp"
#include "waymark/config/nearest_name.hpp"

namespace waymark::config {
namespace {

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

std::string nearest_key(std::string_view key, const std::vector<std::string>& keys) {
  for (const std::string& candidate : keys) {
    if (candidate != key && without_unit(candidate) == without_unit(key)) return candidate;
  }
  return nearest_name(key, keys);
}

}  // namespace waymark::config
