// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <stdexcept>
#include <string>
#include <string_view>

#include "number_text.hpp"

namespace waymark::csv {

/// Why a row cannot be used. Caught where rows are read; never leaves the plugin.
class BadRow : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Throws BadRow for the field of the column `label` that turned out to be no number.
[[noreturn]] void reject(std::string_view field, const std::string& label, NumberText text);

/// The number in a field. Throws BadRow if there is none, or if it is not finite.
inline double finite_number(std::string_view field, const std::string& label) {
  double value = 0.0;
  const NumberText text = parse_number(field, value);
  if (text != NumberText::ok) reject(field, label, text);
  if (!std::isfinite(value)) throw BadRow(in_quotes(field) + " in " + label + " is not finite");
  return value;
}

}  // namespace waymark::csv
