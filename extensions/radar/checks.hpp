// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdio>
#include <string>

namespace waymark::radar {

/// Counts what fails, for programs that check without a test framework.
class Checks {
 public:
  void expect(bool holds, const std::string& what) {
    if (holds) return;
    std::fprintf(stderr, "failed: %s\n", what.c_str());
    ++failed_;
  }
  void near(double value, double expected, double tolerance, const std::string& what) {
    expect(std::abs(value - expected) <= tolerance,
           what + ": " + std::to_string(value) + ", expected " + std::to_string(expected));
  }
  int result() const { return failed_ == 0 ? 0 : 1; }

 private:
  int failed_ = 0;
};

}  // namespace waymark::radar
