// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <csignal>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "commands.hpp"
#include "evaluate_command.hpp"
#include "waymark/error.hpp"

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
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help
    const std::vector<std::string> unknown = app.remaining();
    const std::string what = unknown.empty() ? error.what() : fmt::format("\"{}\" is not expected", unknown.front());
    fmt::print(stderr,
               "waymark: error: {} (subcommands are run, check, plugins, evaluate, map, paper; each explains itself "
               "with --help)\n",
               what);
    return waymark::kUsage;
  } catch (const waymark::Error& error) {
    fmt::print(stderr, "waymark: error: {}\n", error.what());
    return waymark::kError;
  } catch (const std::exception& error) {
    fmt::print(stderr, "waymark: error: internal, please report: {}\n", error.what());
    return waymark::kError;
  }
  return exit_code;
}
