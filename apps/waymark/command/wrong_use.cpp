// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/command/wrong_use.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include "waymark/config/nearest_name.hpp"

namespace waymark::command {

namespace {

/// The subcommand, of a subcommand if need be, at which parsing stopped.
const CLI::App& innermost(const CLI::App& app) {
  const std::vector<CLI::App*> parsed = app.get_subcommands();
  return parsed.empty() ? app : innermost(*parsed.back());
}

std::vector<std::string> names_of_options(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

}  // namespace

std::vector<std::string> names_of_subcommands(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* subcommand : app.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(subcommand->get_name());
  return names;
}

std::string did_you_mean(const std::string& asked, const std::vector<std::string>& names) {
  const std::string near = nearest_name(asked, names);
  // Of a short word half must be right: --out is not nearly --set.
  const std::size_t letters = asked.size() - std::min(asked.find_first_not_of('-'), asked.size());
  if (near.empty() || 2 * edit_distance(asked, near) > letters) return "";
  std::string others;  // as near: --set and --seed of --sed
  for (const std::string& name : names) {
    if (name != near && edit_distance(asked, name) == edit_distance(asked, near))
      others += fmt::format(" or \"{}\"", name);
  }
  return fmt::format("; did you mean \"{}\"{}?", near, others);
}

std::string wrong_use(const CLI::App& app, const CLI::ParseError& error) {
  const CLI::App& command = innermost(app);
  const std::vector<std::string> subcommands = names_of_subcommands(command);
  const std::vector<std::string> unknown = app.remaining(true);
  std::string what = error.what();
  if (!unknown.empty()) {
    const std::string& word = unknown.front();
    const std::string option = word.substr(0, word.find('='));
    what = fmt::format(
        "\"{}\" is not expected{}", word,
        word.starts_with('-') ? did_you_mean(option, names_of_options(command)) : did_you_mean(word, subcommands));
  }
  std::string path;
  for (const CLI::App* of = &command; of->get_parent() != nullptr; of = of->get_parent())
    path.insert(0, ' ' + of->get_name());
  // Of those that work without a subcommand, too, the help says more than a list.
  if (subcommands.empty() || command.get_require_subcommand_min() == 0)
    return fmt::format("{} (see waymark help{})", what, path);
  return fmt::format("{} (subcommands are {}; each has a --help of its own)", what, fmt::join(subcommands, ", "));
}

}  // namespace waymark::command
