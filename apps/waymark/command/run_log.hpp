// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <string_view>
#include <utility>

namespace waymark::command {

/// How much of a message a reader must know, most important first.
enum class LogLevel { error, warning, info, debug };

/// Messages of a run on standard error, up to a level. Where that is systemd's journal (JOURNAL_STREAM), each line has
/// its priority in front (sd-daemon(3)), so that `journalctl -p warning` finds it.
class RunLog {
 public:
  explicit RunLog(LogLevel most);

  bool shows(LogLevel level) const { return level <= most_; }
  /// Prints one line. `text` ends with a newline.
  template <class... Args>
  void print(LogLevel level, fmt::format_string<Args...> text, Args&&... args) const {
    if (shows(level)) write(level, fmt::format(text, std::forward<Args>(args)...));
  }

 private:
  void write(LogLevel level, std::string_view line) const;

  LogLevel most_;
  bool to_journal_;
};

/// "error", "warning", "info" or "debug". Throws std::out_of_range for another word.
LogLevel log_level(std::string_view word);

}  // namespace waymark::command
