// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace waymark::command {

/// What is wrong with a command line that was not parsed, in one line: with the nearest subcommand or option, and where
/// its help is.
std::string wrong_use(const CLI::App& app, const CLI::ParseError& error);

/// Names of the subcommands, in the order of the help.
std::vector<std::string> names_of_subcommands(const CLI::App& app);

/// All that are as near: "; did you mean \"run\"?", or nothing.
std::string did_you_mean(const std::string& asked, const std::vector<std::string>& names);

}  // namespace waymark::command
