// SPDX-License-Identifier: Apache-2.0
#include "waymark/testing/violations.hpp"

namespace waymark::testing {

std::string to_text(const Violations& violations) {
  std::string text;
  for (const std::string& violation : violations) text += violation + "\n";
  return text;
}

}  // namespace waymark::testing
