// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

namespace waymark {

/// Adds `evaluate`: scores a trajectory against a reference and a landmark map against a survey, and prints the result
/// to standard output. The command throws Error for what the user can mend; `exit_code` becomes 0 when it has run.
void add_evaluate_command(CLI::App& app, int& exit_code);

}  // namespace waymark
