// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

namespace waymark::command {

/// What the command ends with.
enum ExitCode {
  kSuccess = 0,
  kError = 1,          ///< a user's error; one line on stderr names what and where
  kUsage = 2,          ///< the command line is wrong; one line on stderr names what
  kImpaired = 3,       ///< the run ended, but a plugin was taken out of service or an output could not be written
  kLost = 4,           ///< the run ended, but its pose was lost for too large a share of it
  kFindings = 5,       ///< `doctor` has found contradictions between the sensors
  kInterrupted = 130,  ///< Ctrl-C: ended cleanly, outputs written
};

/// Each adds one subcommand; it runs when parsing ends and sets `exit_code`.
void add_run_command(CLI::App& app, int& exit_code);
void add_check_command(CLI::App& app, int& exit_code);
void add_doctor_command(CLI::App& app, int& exit_code);
void add_plugins_command(CLI::App& app, int& exit_code);
void add_evaluate_command(CLI::App& app, int& exit_code);
void add_map_command(CLI::App& app, int& exit_code);
void add_calibrate_command(CLI::App& app, int& exit_code);
void add_ctl_command(CLI::App& app, int& exit_code);
void add_import_command(CLI::App& app, int& exit_code);
void add_paper_command(CLI::App& app, int& exit_code);
void add_sweep_command(CLI::App& app, int& exit_code);
void add_schema_command(CLI::App& app, int& exit_code);
void add_new_command(CLI::App& app, int& exit_code);
/// The last one: it describes the others.
void add_help_command(CLI::App& app, int& exit_code);

}  // namespace waymark::command
