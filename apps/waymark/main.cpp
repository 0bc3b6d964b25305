// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <string>
#include <system_error>

#include "apps/waymark/command/command_line.hpp"
#include "apps/waymark/command/commands.hpp"
#include "apps/waymark/command/wrong_use.hpp"
#include "waymark/base/error.hpp"

namespace command = waymark::command;

namespace {

/// A closed standard stream is taken by the next file that is opened, and what is printed would go into that file.
void open_standard_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(stream, F_GETFD) != -1 || errno != EBADF) continue;
    // The lowest free number is this one's.
    if (open("/dev/null", stream == STDIN_FILENO ? O_RDONLY : O_WRONLY) != stream) std::_Exit(command::kError);
  }
}

std::atomic<bool> has_ended{false};

// A plugin that calls exit, even exit(0) while it is loaded, must not make half a run look like a good one. This
// program itself ends by returning from main only.
void on_exit() {
  if (has_ended) return;
  command::print_message("waymark: error: a plugin ended the program\n");
  _exit(command::kError);
}

int run_command(int argc, char** argv) {
  // A full disk or a closed pipe is an error to report, not a signal to die of.
  std::signal(SIGXFSZ, SIG_IGN);
  std::signal(SIGPIPE, SIG_IGN);

  CLI::App app{
      "waymark: where is my robot, and what does the world look like\n\n"
      "Example:\n  waymark run config/quickstart.yaml --out out/quickstart\n"};
  app.require_subcommand(1);
  app.set_version_flag("--version", "waymark " WAYMARK_VERSION);
  int exit_code = command::kSuccess;
  command::add_run_command(app, exit_code);
  command::add_check_command(app, exit_code);
  command::add_doctor_command(app, exit_code);
  command::add_calibrate_command(app, exit_code);
  command::add_plugins_command(app, exit_code);
  command::add_evaluate_command(app, exit_code);
  command::add_map_command(app, exit_code);
  command::add_ctl_command(app, exit_code);
  command::add_import_command(app, exit_code);
  command::add_paper_command(app, exit_code);
  command::add_sweep_command(app, exit_code);
  command::add_schema_command(app, exit_code);
  command::add_new_command(app, exit_code);
  command::add_help_command(app, exit_code);
  try {
    app.parse(argc, argv);
    // What was printed must be there: a full disk must not end with half a table and "all well".
    if (std::fflush(stdout) != 0) throw std::system_error(errno, std::generic_category());
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    command::print_message("waymark: error: {}\n", command::wrong_use(app, error));
    return command::kUsage;
  } catch (const command::UsageError& error) {
    command::print_message("waymark: error: {}\n", error.what());
    return command::kUsage;
  } catch (const waymark::Error& error) {
    command::print_message("waymark: error: {}\n", error.what());
    return command::kError;
  } catch (const std::filesystem::filesystem_error& error) {
    command::print_message("waymark: error: {}\n", error.what());
    return command::kError;
  } catch (const std::system_error& error) {
    // Who closed the pipe has seen enough: `waymark check robot.yaml | head`.
    if (error.code() == std::errc::broken_pipe) return command::kSuccess;
    command::print_message("waymark: error: standard output: {}\n", error.code().message());
    return command::kError;
  } catch (const std::exception& error) {
    command::print_message("waymark: error: internal, please report: {}\n", error.what());
    return command::kError;
  }
  return exit_code;
}

}  // namespace

int main(int argc, char** argv) {
  open_standard_streams();
  std::atexit(on_exit);
  std::at_quick_exit(on_exit);
  const int exit_code = run_command(argc, argv);
  has_ended = true;
  return exit_code;
}
