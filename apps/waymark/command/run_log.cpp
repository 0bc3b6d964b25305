// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/command/run_log.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cstddef>
#include <cstdlib>
#include <stdexcept>
#include <string>

#include "apps/waymark/command/command_line.hpp"

namespace waymark::command {
namespace {

constexpr std::array<std::string_view, 4> kWords{"error", "warning", "info", "debug"};
constexpr std::array<int, 4> kPriorities{3, 4, 6, 7};  // syslog(3)

/// JOURNAL_STREAM has device and inode of the stream that systemd opened; standard error may be another one by now.
bool is_journal(int descriptor) {
  const char* journal = std::getenv("JOURNAL_STREAM");
  struct stat status {};
  if (journal == nullptr || ::fstat(descriptor, &status) != 0) return false;
  return fmt::format("{}:{}", status.st_dev, status.st_ino) == journal;
}

}  // namespace

RunLog::RunLog(LogLevel most) : most_(most), to_journal_(is_journal(STDERR_FILENO)) {}

void RunLog::write(LogLevel level, std::string_view line) const {
  if (to_journal_) {
    print_message("<{}>{}", kPriorities[static_cast<std::size_t>(level)], line);
  } else {
    print_message("{}", line);
  }
}

LogLevel log_level(std::string_view word) {
  for (std::size_t i = 0; i < kWords.size(); ++i) {
    if (kWords[i] == word) return static_cast<LogLevel>(i);
  }
  throw std::out_of_range("no level of messages: " + std::string(word));
}

}  // namespace waymark::command
