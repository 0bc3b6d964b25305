// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace waymark::command {

/// What is made of the declarations of subcommands and options.
std::string man_page(const CLI::App& app);         ///< of all, section 1 (groff_man(7))
std::string bash_completion(const CLI::App& app);  ///< a script to be sourced
std::string zsh_completion(const CLI::App& app);   ///< a function `_waymark` for fpath

}  // namespace waymark::command
