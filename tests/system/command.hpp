// SPDX-License-Identifier: Apache-2.0
// Runs the built `waymark` as a user would.
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "temporary_folder.hpp"

namespace waymark::system_test {

/// The whole file as text; empty if it cannot be read.
inline std::string read_text(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

inline void write_text(const std::filesystem::path& file, std::string_view text) {
  std::ofstream out(file, std::ios::binary);
  out << text;
  if (!out.flush()) throw std::runtime_error("cannot write " + file.string());
}

inline std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

using test::TemporaryFolder;

/// For Command::in_child: root may write anywhere, so the child becomes nobody.
inline void drop_privileges() {
  constexpr uid_t kNobody = 65534;
  if (::geteuid() == 0 && (::setgid(kNobody) != 0 || ::setuid(kNobody) != 0)) ::_exit(126);
}

/// How a command ended. `exit_code` is 128 + n if signal n killed it, -1 if it was stopped for lack of time.
struct Outcome {
  int exit_code = -1;
  std::string out;
  std::string err;

  /// The lines of stderr that announce an error.
  std::vector<std::string> errors() const {
    std::vector<std::string> found;
    for (const std::string& line : lines_of(err)) {
      if (line.starts_with("waymark: error: ")) found.push_back(line);
    }
    return found;
  }
};

/// One start of `waymark` with the given arguments. Nothing passes through a shell.
class Command {
 public:
  explicit Command(std::vector<std::string> arguments) : arguments_(std::move(arguments)) {}

  /// Called in the child before the program starts: limits, privileges. Only async-signal-safe calls.
  Command& in_child(std::function<void()> prepare) {
    prepare_ = std::move(prepare);
    return *this;
  }
  Command& with_environment(const std::string& name, const std::string& value) {
    environment_.emplace_back(name, value);
    return *this;
  }
  Command& without_environment(const std::string& name) {
    environment_.emplace_back(name, std::nullopt);
    return *this;
  }
  /// Sends `signal_number` as soon as `ready` is true.
  Command& send(int signal_number, std::function<bool()> ready) {
    signal_ = signal_number;
    ready_ = std::move(ready);
    return *this;
  }
  Command& timeout(std::chrono::seconds limit) {
    limit_ = limit;
    return *this;
  }

  Outcome run() const {
    const TemporaryFolder captured;
    const std::string out_file = captured / "stdout";
    const std::string err_file = captured / "stderr";
    std::vector<char*> arguments{const_cast<char*>(WAYMARK_BINARY)};
    for (const std::string& argument : arguments_) arguments.push_back(const_cast<char*>(argument.c_str()));
    arguments.push_back(nullptr);

    const int out = ::open(out_file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    const int err = ::open(err_file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (out < 0 || err < 0) throw std::runtime_error("cannot capture the output");
    const pid_t child = ::fork();
    if (child < 0) throw std::runtime_error("cannot fork");
    if (child == 0) {
      ::dup2(out, STDOUT_FILENO);
      ::dup2(err, STDERR_FILENO);
      for (const auto& [name, value] : environment_) {
        if (value) {
          ::setenv(name.c_str(), value->c_str(), 1);
        } else {
          ::unsetenv(name.c_str());
        }
      }
      if (prepare_) prepare_();
      ::execv(WAYMARK_BINARY, arguments.data());
      ::_exit(127);
    }
    ::close(out);
    ::close(err);
    Outcome outcome;
    outcome.exit_code = wait_for(child);
    outcome.out = read_text(out_file);
    outcome.err = read_text(err_file);
    return outcome;
  }

 private:
  int wait_for(pid_t child) const {
    using Clock = std::chrono::steady_clock;
    const auto end = Clock::now() + limit_;
    bool to_send = static_cast<bool>(ready_);
    for (;;) {
      int status = 0;
      const pid_t ended = ::waitpid(child, &status, WNOHANG);
      if (ended == child) return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
      if (ended < 0 && errno != EINTR) throw std::runtime_error("waitpid failed");
      if (to_send && ready_()) {
        ::kill(child, signal_);
        to_send = false;
      }
      if (Clock::now() > end) {
        ::kill(child, SIGKILL);
        ::waitpid(child, &status, 0);
        return -1;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  }

  std::vector<std::string> arguments_;
  std::function<void()> prepare_;
  std::vector<std::pair<std::string, std::optional<std::string>>> environment_;
  int signal_ = 0;
  std::function<bool()> ready_;
  std::chrono::seconds limit_{300};
};

inline Outcome waymark(std::vector<std::string> arguments) { return Command(std::move(arguments)).run(); }

/// Passes if the command ended with `exit_code` and reported one error in one line, which holds every one of
/// `parts`.
inline testing::AssertionResult reports_error(const Outcome& outcome, int exit_code,
                                              const std::vector<std::string>& parts) {
  const auto all = [&] { return "\nstderr:\n" + outcome.err; };
  if (outcome.exit_code != exit_code) {
    return testing::AssertionFailure() << "exit code " << outcome.exit_code << ", expected " << exit_code << all();
  }
  const std::vector<std::string> errors = outcome.errors();
  if (errors.size() != 1) return testing::AssertionFailure() << errors.size() << " error lines, expected 1" << all();
  for (const std::string& part : parts) {
    if (errors.front().find(part) == std::string::npos) {
      return testing::AssertionFailure() << "the line does not hold \"" << part << "\"" << all();
    }
  }
  for (const char* sign : {"internal error", "terminate called", "Sanitizer"}) {
    if (outcome.err.find(sign) != std::string::npos) return testing::AssertionFailure() << sign << all();
  }
  return testing::AssertionSuccess() << errors.front();
}

/// Passes if the file has at least `least` lines, the last one ends, and each has as many fields as the last of the
/// first two.
inline testing::AssertionResult has_complete_lines(const std::filesystem::path& file, std::size_t least) {
  const std::string text = read_text(file);
  if (text.empty()) return testing::AssertionFailure() << file << " is missing or empty";
  if (text.back() != '\n') return testing::AssertionFailure() << file << " ends within a line";
  const char separator = file.extension() == ".csv" ? ',' : ' ';
  std::optional<std::int64_t> fields;
  std::size_t rows = 0;
  for (const std::string& line : lines_of(text)) {
    if (line.starts_with("#")) continue;
    ++rows;
    const std::int64_t count = std::count(line.begin(), line.end(), separator);
    if (fields && count != *fields)
      return testing::AssertionFailure() << file << ": the row \"" << line << "\" is not complete";
    fields = count;
  }
  if (rows < least)
    return testing::AssertionFailure() << file << " has " << rows << " rows, expected " << least << " or more";
  return testing::AssertionSuccess();
}

/// Passes if no output was left half written.
inline testing::AssertionResult has_no_partial_file(const std::filesystem::path& folder) {
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".partial")
      return testing::AssertionFailure() << entry.path() << " was left behind";
  }
  return testing::AssertionSuccess();
}

}  // namespace waymark::system_test
