// SPDX-License-Identifier: Apache-2.0
// Runs the contract kit on our source: prints all violations, and fails if there is one.
#include <cstdio>

#include "circle.cpp"
#include "waymark/testing/source_contract.hpp"

int main() {
  const auto make_source = [] {
    return std::make_shared<Circle>(
        Config::parse("{ samples: 200, radius_m: 4, twist_to: wheels, range_to: radio, dock_to: camera }"));
  };
  const testing::Violations found = testing::check_source(make_source);
  std::fputs(testing::to_text(found).c_str(), stderr);
  return found.empty() ? 0 : 1;
}
