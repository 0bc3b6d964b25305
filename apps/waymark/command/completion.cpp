// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string>
#include <vector>

#include "apps/waymark/command/command_pages.hpp"
#include "apps/waymark/command/command_tree.hpp"
#include "apps/waymark/command/wrong_use.hpp"

namespace waymark::command {

namespace {

std::vector<std::string> flags_of(const CLI::App& command) {
  std::vector<std::string> flags;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) flags.push_back("--" + name);
  }
  return flags;
}

/// What follows a command's name: its subcommands and its options; the words that an option takes.
std::string bash_case(const std::string& name, const CLI::App& command) {
  std::string out = fmt::format("    \"{}\") words=\"{} {}\" ;;\n", name, fmt::join(names_of_subcommands(command), " "),
                                fmt::join(flags_of(command), " "));
  return out;
}

std::string zsh_text(std::string text) {
  for (std::size_t at = 0; (at = text.find_first_of("'[]:\\`$\"", at)) != std::string::npos; at += 2) {
    if (text[at] == '\'' || text[at] == '`' || text[at] == '"' || text[at] == '$') {
      text.replace(at, 1, 1, ' ');
      --at;
      continue;
    }
    text.insert(at, 1, '\\');
  }
  return text;
}

std::string zsh_option(const CLI::Option& option) {
  std::string out;
  for (const std::string& name : option.get_lnames()) {
    const std::vector<std::string> words = words_of(option);
    const std::string value = !takes_value(option) ? ""
                              : words.empty()      ? fmt::format(":{}:_files", name)
                                                   : fmt::format(":{}:({})", name, fmt::join(words, " "));
    const bool repeats = option.get_items_expected_max() > 1;
    out +=
        fmt::format("        '{}--{}[{}]{}' \\\n", repeats ? "*" : "", name, zsh_text(option.get_description()), value);
  }
  return out;
}

/// Names with descriptions, for _describe.
std::string zsh_subcommands(const CLI::App& command) {
  std::string out;
  for (const CLI::App* inner : command.get_subcommands([](const CLI::App*) { return true; }))
    out += fmt::format("        '{}:{}'\n", inner->get_name(), zsh_text(inner->get_description()));
  return out;
}

}  // namespace

std::string bash_completion(const CLI::App& app) {
  std::string out =
      "# Completion of waymark for bash; made by `waymark help --completion bash`.\n"
      "_waymark() {\n"
      "  local current=\"${COMP_WORDS[COMP_CWORD]}\" before=\"${COMP_WORDS[COMP_CWORD-1]}\" command=\"\" words=\"\" i\n"
      "  for ((i = 1; i < COMP_CWORD; i++)); do\n"
      "    case \"$command ${COMP_WORDS[i]}\" in\n";
  const std::vector<NamedCommand> all = all_subcommands(app);
  for (const auto& [name, command] : all) {
    const bool is_inner = name.find(' ') != std::string::npos;
    out += fmt::format("      \"{}{}\") command=\"{}\" ;;\n", is_inner ? "" : " ", name, name);
  }
  out += "    esac\n  done\n  case \"$command $before\" in\n";
  for (const auto& [name, command] : all) {
    for (const CLI::Option* option : command->get_options()) {
      const std::vector<std::string> words = words_of(*option);
      if (words.empty()) continue;
      for (const std::string& flag : option->get_lnames())
        out += fmt::format("    \"{} --{}\") COMPREPLY=($(compgen -W \"{}\" -- \"$current\")); return ;;\n", name, flag,
                           fmt::join(words, " "));
    }
  }
  out += "  esac\n  case \"$command\" in\n" + bash_case("", app);
  for (const auto& [name, command] : all) out += bash_case(name, *command);
  return out +
         "  esac\n"
         "  COMPREPLY=($(compgen -W \"$words\" -- \"$current\"))\n"
         "}\n"
         "complete -o default -F _waymark waymark\n";
}

std::string zsh_completion(const CLI::App& app) {
  std::string out =
      "#compdef waymark\n# Completion of waymark for zsh; made by `waymark help --completion zsh`.\n"
      "_waymark() {\n"
      "  local context state state_descr line\n  typeset -A opt_args\n"
      "  local -a subcommands=(\n" +
      zsh_subcommands(app) +
      "  )\n"
      "  _arguments -C '--help[print help]' '--version[print the version]' '1: :->command' '*:: :->rest'\n"
      "  case $state in\n"
      "    command) _describe 'subcommand' subcommands ;;\n"
      "    rest) case $words[1] in\n";
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    out += fmt::format("      {})\n", command->get_name());
    const std::vector<std::string> inner = names_of_subcommands(*command);
    out += "        _arguments \\\n";
    for (const CLI::Option* option : command->get_options()) out += zsh_option(*option);
    for (const NamedCommand& of : all_subcommands(*command)) {
      for (const CLI::Option* option : of.command->get_options()) {
        if (!option->get_lnames().empty() && option->get_lnames().front() != "help") out += zsh_option(*option);
      }
    }
    if (inner.empty()) {
      out += "        '*: :_files' ;;\n";
    } else {
      out += fmt::format("        '1: :({})' '*: :_files' ;;\n", fmt::join(inner, " "));
    }
  }
  return out +
         "    esac ;;\n"
         "  esac\n"
         "}\n"
         "_waymark \"$@\"\n";
}

}  // namespace waymark::command
