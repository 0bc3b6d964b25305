// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace waymark::fuzz {

/// A parser under test, made once per harness as a constant of its file. All are one program; the name by which it is
/// called, `fuzz_<name>`, selects one.
class Harness {
 public:
  /// `run` parses one input. What it throws, and what it lets a sanitizer find, is a finding.
  Harness(std::string_view name, void (*run)(std::string_view input));

  std::string_view name;
  void (*run)(std::string_view input);
};

}  // namespace waymark::fuzz
