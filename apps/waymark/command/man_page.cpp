// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <string>
#include <string_view>

#include "apps/waymark/command/command_pages.hpp"
#include "apps/waymark/command/command_tree.hpp"

namespace waymark::command {

namespace {

/// Text for groff: a line that begins with a dot or a quote would be a request.
std::string groff(std::string_view text) {
  std::string result;
  bool at_line_start = true;
  for (const char c : text) {
    if (at_line_start && (c == '.' || c == '\'')) result += "\\&";
    if (c == '\\') {
      result += "\\e";
    } else if (c == '-') {
      result += "\\-";
    } else {
      result += c;
    }
    at_line_start = c == '\n';
  }
  return result;
}

std::string option_entry(const CLI::Option& option) {
  const bool is_positional = option.get_positional();
  const std::string words = fmt::format("{}", fmt::join(words_of(option), "|"));
  const std::string value = is_positional || !takes_value(option) ? "" : words.empty() ? " VALUE" : ' ' + words;
  std::string fallback;
  if (!option.get_default_str().empty()) fallback = fmt::format(" (default: {})", option.get_default_str());
  return fmt::format(".TP\n.B {}\n{}\n", groff(is_positional ? option.get_name(true) : names_of(option) + value),
                     groff(option.get_description() + fallback));
}

std::string synopsis(const std::string& name, const CLI::App& command) {
  std::string text = "waymark " + name;
  for (const CLI::Option* option : command.get_options()) {
    if (!option->get_positional()) continue;
    const std::string value = option->get_name(true) + (option->get_items_expected_max() > 1 ? "..." : "");
    text += option->get_required() ? ' ' + value : " [" + value + ']';
  }
  return text + " [options]";
}

}  // namespace

std::string man_page(const CLI::App& app) {
  std::string out = fmt::format(".TH WAYMARK 1 \"\" \"waymark {}\" \"User Commands\"\n", WAYMARK_VERSION);
  out +=
      ".SH NAME\nwaymark \\- fuses what a robot measures into its pose and a map\n.SH SYNOPSIS\n.B waymark\n"
      ".I subcommand\n[options]\n.SH DESCRIPTION\n";
  out += groff(app.get_description()) + '\n';
  for (const auto& [name, command] : all_subcommands(app)) {
    out += fmt::format(".SH {}\n.nf\n.B {}\n.fi\n.PP\n{}\n", groff(name), groff(synopsis(name, *command)),
                       groff(command->get_description()));
    for (const CLI::Option* option : command->get_options()) out += option_entry(*option);
    if (!command->get_footer().empty()) out += fmt::format(".PP\n.nf\n{}\n.fi\n", groff(command->get_footer()));
  }
  return out + ".SH SEE ALSO\nThe documentation of waymark, in its folder docs.\n";
}

}  // namespace waymark::command
