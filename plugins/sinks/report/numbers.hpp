// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <nlohmann/json.hpp>

namespace waymark::report {

/// Keeps the order in which members are added.
using Json = nlohmann::ordered_json;

/// A number with so many decimals; null if it is not finite, which JSON does not have.
inline Json decimals(double value, int count) {
  if (!std::isfinite(value)) return nullptr;
  const double unit = std::pow(10.0, count);
  const double scaled = value * unit;
  // Beyond, a double has no such decimals.
  if (std::abs(scaled) > 1e15) return value;
  const double rounded = std::round(scaled) / unit;
  return rounded == 0.0 ? Json(0) : Json(rounded);
}

/// A length or coordinate, in tenths of a millimetre.
inline Json metres(double value) { return decimals(value, 4); }

/// A number with four digits that count.
inline Json digits(double value) {
  if (!std::isfinite(value)) return nullptr;
  if (value == 0.0) return 0;
  return decimals(value, 3 - static_cast<int>(std::floor(std::log10(std::abs(value)))));
}

}  // namespace waymark::report
