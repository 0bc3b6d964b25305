// SPDX-License-Identifier: Apache-2.0
#include "bad_row.hpp"

namespace waymark::csv {

void reject(std::string_view field, const std::string& label, NumberText text) {
  switch (text) {
    case NumberText::empty:
      throw BadRow(label + " is empty, a number is expected");
    case NumberText::out_of_range:
      throw BadRow(in_quotes(field) + " in " + label + " is out of range");
    default:
      throw BadRow(in_quotes(field) + " in " + label + " is not a number");
  }
}

}  // namespace waymark::csv
