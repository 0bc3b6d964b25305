// SPDX-License-Identifier: Apache-2.0
// What a page about the command line reads of the declarations.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace waymark::command {

/// A subcommand with its whole name: "map convert".
struct NamedCommand {
  std::string name;
  const CLI::App* command;
};

/// The subcommands of `app` and, after each, its own.
inline std::vector<NamedCommand> all_subcommands(const CLI::App& app, const std::string& of = "") {
  std::vector<NamedCommand> all;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    all.push_back({of + command->get_name(), command});
    for (NamedCommand& inner : all_subcommands(*command, of + command->get_name() + ' '))
      all.push_back(std::move(inner));
  }
  return all;
}

/// "--out", or "-h,--help".
inline std::string names_of(const CLI::Option& option) { return option.get_name(false, true); }

/// True if the option has a value.
inline bool takes_value(const CLI::Option& option) { return option.get_items_expected_max() > 0; }

/// The words that a value may be, if the option lists them.
inline std::vector<std::string> words_of(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const std::size_t begin = type.find('{');
  const std::size_t end = type.find('}', begin);
  std::vector<std::string> words;
  if (begin == std::string::npos || end == std::string::npos) return words;
  return CLI::detail::split(type.substr(begin + 1, end - begin - 1), ',');
}

}  // namespace waymark::command
