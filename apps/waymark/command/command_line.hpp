// SPDX-License-Identifier: Apache-2.0
// What the commands have in common on the command line: wrong use, numbers, what is printed.
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>
#include <string_view>
#include <utility>

#include "apps/waymark/command/visible_text.hpp"
#include "waymark/base/error.hpp"

namespace waymark::command {

/// The command line is wrong: exit code kUsage.
class UsageError : public Error {
 public:
  using Error::Error;
};

/// Prints a message on standard error, as one line, with control characters made visible. A closed standard error does
/// not end a run.
template <class... Args>
void print_message(fmt::format_string<Args...> text, Args&&... args) {
  const std::string line = visible_line(fmt::format(text, std::forward<Args>(args)...));
  std::fwrite(line.data(), 1, line.size(), stderr);
}

/// Prints a text on standard output; on a terminal with control characters made visible, since names from a YAML or a
/// table are in it. Into a file or a pipe it goes as it is. Throws std::system_error if it cannot be written.
void print_text(std::string_view text);

/// The same for a format and its arguments.
template <class... Args>
void print_output(fmt::format_string<Args...> text, Args&&... args) {
  print_text(fmt::format(text, std::forward<Args>(args)...));
}

/// Checks of options that are numbers; NaN and infinity are none.
CLI::Validator finite_number();
CLI::Validator positive_number();
CLI::Validator non_negative_number();

}  // namespace waymark::command
