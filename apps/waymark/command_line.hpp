// SPDX-License-Identifier: Apache-2.0
// What the commands have in common on the command line: wrong use, numbers, words on standard error.
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>
#include <utility>

#include "waymark/base/error.hpp"

namespace waymark {

/// The command line is wrong: exit code kUsage.
class UsageError : public Error {
 public:
  using Error::Error;
};

/// Says something on standard error. That nobody can read it is no reason to end a run.
template <class... Args>
void say(fmt::format_string<Args...> text, Args&&... args) {
  const std::string line = fmt::format(text, std::forward<Args>(args)...);
  std::fwrite(line.data(), 1, line.size(), stderr);
}

/// Checks of options that are numbers; NaN and infinity are none.
CLI::Validator finite_number();
CLI::Validator positive_number();
CLI::Validator non_negative_number();

}  // namespace waymark
