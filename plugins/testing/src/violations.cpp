// SPDX-License-Identifier: Apache-2.0
#include "waymark/testing/violations.hpp"

#include <cstdio>

namespace waymark::testing {

std::string to_text(const Violations& violations) {
  std::string text;
  for (const std::string& violation : violations) text += violation + "\n";
  return text;
}

int report(std::initializer_list<Violations> checks) {
  int exit_code = 0;
  for (const Violations& violations : checks) {
    if (violations.empty()) continue;
    std::fputs(to_text(violations).c_str(), stderr);
    exit_code = 1;
  }
  return exit_code;
}

}  // namespace waymark::testing
