// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "command_line.hpp"
#include "commands.hpp"
#include "evaluate_command.hpp"
#include "waymark/base/error.hpp"

int main(int argc, char** argv) {
  // A full disk or a closed pipe is an error to report, not a signal to die of.
  std::signal(SIGXFSZ, SIG_IGN);
  std::signal(SIGPIPE, SIG_IGN);

  CLI::App app{
      "waymark: where is my robot, and what does the world look like\n\n"
      "Example:\n  waymark run config/quickstart.yaml --out out/quickstart\n"};
  app.require_subcommand(1);
  int exit_code = waymark::kSuccess;
  waymark::add_run_command(app, exit_code);
  waymark::add_check_command(app, exit_code);
  waymark::add_plugins_command(app, exit_code);
  waymark::add_evaluate_command(app, exit_code);
  waymark::add_map_command(app, exit_code);
  waymark::add_paper_command(app, exit_code);
  try {
    app.parse(argc, argv);
    // What was printed must be there: a full disk must not end with half a table and "all well".
    if (std::fflush(stdout) != 0) throw std::system_error(errno, std::generic_category());
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help
    const std::vector<std::string> unknown = app.remaining();
    const std::string what = unknown.empty() ? error.what() : fmt::format("\"{}\" is not expected", unknown.front());
    waymark::say(
        "waymark: error: {} (subcommands are run, check, plugins, evaluate, map, paper; each explains itself "
        "with --help)\n",
        what);
    return waymark::kUsage;
  } catch (const waymark::UsageError& error) {
    waymark::say("waymark: error: {}\n", error.what());
    return waymark::kUsage;
  } catch (const waymark::Error& error) {
    waymark::say("waymark: error: {}\n", error.what());
    return waymark::kError;
  } catch (const std::filesystem::filesystem_error& error) {
    waymark::say("waymark: error: {}\n", error.what());
    return waymark::kError;
  } catch (const std::system_error& error) {
    // Who closed the pipe has seen enough: `waymark check robot.yaml | head`.
    if (error.code() == std::errc::broken_pipe) return waymark::kSuccess;
    waymark::say("waymark: error: standard output: {}\n", error.code().message());
    return waymark::kError;
  } catch (const std::exception& error) {
    waymark::say("waymark: error: internal, please report: {}\n", error.what());
    return waymark::kError;
  }
  return exit_code;
}
