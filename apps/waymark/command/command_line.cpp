// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/command/command_line.hpp"

#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <limits>
#include <optional>
#include <system_error>

namespace waymark::command {

namespace {

std::optional<double> number_of(const std::string& text) {
  double number = 0.0;
  if (!CLI::detail::lexical_cast(text, number) || !std::isfinite(number)) return std::nullopt;
  return number;
}

CLI::Validator number_from(double least, bool least_itself, const std::string& expected) {
  return CLI::Validator(
      [=](std::string& text) {
        const auto number = number_of(text);
        if (number && (*number > least || (least_itself && *number == least))) return std::string();
        return fmt::format("\"{}\" is not {}", text, expected);
      },
      "");
}

}  // namespace

void print_text(std::string_view text) {
  const std::string shown = isatty(STDOUT_FILENO) != 0 ? visible_text(text) : std::string(text);
  if (std::fwrite(shown.data(), 1, shown.size(), stdout) != shown.size())
    throw std::system_error(errno, std::generic_category());
}

CLI::Validator finite_number() { return number_from(std::numeric_limits<double>::lowest(), true, "a finite number"); }
CLI::Validator positive_number() { return number_from(0.0, false, "a finite number above 0"); }
CLI::Validator non_negative_number() { return number_from(0.0, true, "a finite number, 0 or more"); }

}  // namespace waymark::command
