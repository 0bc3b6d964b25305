// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/command/batch.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <fstream>
#include <iterator>

#include "apps/waymark/command/command_line.hpp"
#include "waymark/base/error.hpp"

namespace waymark::command {

void report_ended(std::size_t ended, std::size_t count, std::string_view what) {
  if (isatty(STDERR_FILENO) == 1) {
    print_message("\r{} of {} {}{}", ended, count, what, ended == count ? "\n" : "");
  } else if (ended * 10 / count != (ended - 1) * 10 / count) {
    print_message("{} of {} {}\n", ended, count, what);
  }
}

void require_replaceable(const std::filesystem::path& page, std::string_view command, std::string_view option) {
  std::ifstream file(page);
  if (!file) return;
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (text.find(fmt::format("Made by\n\n    {} ", command)) == std::string::npos)
    throw Error(
        fmt::format("{}: not written by `{}`, so it is kept; choose another {}", page.string(), command, option));
}

}  // namespace waymark::command
