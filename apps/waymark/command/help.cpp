// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>
#include <string>
#include <vector>

#include "apps/waymark/command/command_line.hpp"
#include "apps/waymark/command/command_pages.hpp"
#include "apps/waymark/command/commands.hpp"
#include "apps/waymark/command/wrong_use.hpp"

namespace waymark::command {

namespace {

struct HelpOptions {
  std::vector<std::string> names;
  bool man = false;
  std::string completion;
};

void print_help_of(const CLI::App& app, const std::vector<std::string>& names) {
  const CLI::App* command = &app;
  std::string path = "waymark";
  std::string above;  // names of the commands above, as the usage shows them
  for (const std::string& name : names) {
    const auto inner = command->get_subcommands([&](const CLI::App* one) { return one->get_name() == name; });
    if (inner.empty()) {
      const std::vector<std::string> known = names_of_subcommands(*command);
      throw UsageError(fmt::format("{} has no subcommand \"{}\"{}{}", path, name, did_you_mean(name, known),
                                   known.empty() ? "" : fmt::format(" (they are {})", fmt::join(known, ", "))));
    }
    above += (above.empty() ? "" : " ") + command->get_name();
    command = inner.front();
    path += ' ' + name;
  }
  // `App::help` of the whole would be that of the subcommand which was called: help.
  const auto normal = CLI::AppFormatMode::Normal;
  print_output("{}", command == &app ? app.get_formatter()->make_help(&app, app.get_name(), normal)
                                     : command->help(above, normal));
}

void help(const CLI::App& app, const HelpOptions& options) {
  if (options.man) {
    print_output("{}", man_page(app));
  } else if (options.completion == "bash") {
    print_output("{}", bash_completion(app));
  } else if (options.completion == "zsh") {
    print_output("{}", zsh_completion(app));
  } else {
    print_help_of(app, options.names);
  }
}

}  // namespace

void add_help_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<HelpOptions>();
  CLI::App* command = app.add_subcommand("help", "Print the help of a subcommand, or the man page");
  command->footer(
      "Example:\n  waymark help run\n  waymark help map convert\n"
      "  waymark help --completion bash > ~/.local/share/bash-completion/completions/waymark");
  auto* names = command->add_option("subcommand", options->names, "the subcommand; without it: all of them");
  auto* man = command->add_flag("--man", options->man, "print the man page, for man -l")->excludes(names);
  command->add_option("--completion", options->completion, "print the completion of this shell")
      ->check(CLI::IsMember({"bash", "zsh"}))
      ->excludes(names)
      ->excludes(man);
  command->callback([&app, options, &exit_code] {
    help(app, *options);
    exit_code = kSuccess;
  });
}

}  // namespace waymark::command
