// SPDX-License-Identifier: Apache-2.0
// What the commands have in common on the command line: wrong use, numbers, messages on standard error.
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>
#include <utility>

#include "apps/waymark/command/visible_text.hpp"
#include "waymark/base/error.hpp"

namespace waymark::command {

/// The command line is wrong: exit code kUsage.
class UsageError : public Error {
 public:
  using Error::Error;
};

/// Prints a message on standard error, with control characters made visible. A closed standard error does not end a
/// run.
template <class... Args>
void print_message(fmt::format_string<Args...> text, Args&&... args) {
  const std::string line = visible_text(fmt::format(text, std::forward<Args>(args)...));
  std::fwrite(line.data(), 1, line.size(), stderr);
}

/// Checks of options that are numbers; NaN and infinity are none.
CLI::Validator finite_number();
CLI::Validator positive_number();
CLI::Validator non_negative_number();

}  // namespace waymark::command
