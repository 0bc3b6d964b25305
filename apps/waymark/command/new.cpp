// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "apps/waymark/command/command_line.hpp"
#include "apps/waymark/command/commands.hpp"
#include "apps/waymark/command/new_plugin.hpp"
#include "waymark/io/output_file.hpp"
#include "waymark/plugin_loader.hpp"

namespace waymark::command {

namespace {

struct NewOptions {
  std::string kind;
  std::string name;
  std::string folder;
};

/// A name becomes that of files, of a library, and of C++ classes.
void require_good_name(const std::string& name) {
  constexpr std::size_t kMost = 48;
  const auto is_good = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_'; };
  const bool starts_well = !name.empty() && name.front() >= 'a' && name.front() <= 'z';
  if (!starts_well || !std::ranges::all_of(name, is_good) || name.ends_with('_') ||
      name.find("__") != std::string::npos) {
    throw UsageError(fmt::format(
        "\"{}\" is no name for a plugin; expected are small letters, digits and single _, from a letter on: "
        "wheel_slip",
        name));
  }
  if (name.size() > kMost)
    throw UsageError(fmt::format("the name has {} characters; at most {} are expected", name.size(), kMost));
}

void require_unused_name(const std::string& name) {
  for (const PluginInfo& plugin : PluginLoader(PluginLoader::standard_search_path()).list()) {
    if (plugin.name != name) continue;
    throw UsageError(fmt::format("there is already a plugin \"{}\", {}; two of one name hide each other", name,
                                 plugin.file.string()));
  }
}

/// "WheelSlip" of "wheel_slip".
std::string class_name(const std::string& name) {
  std::string out;
  bool starts_word = true;
  for (const char c : name) {
    if (c != '_') out += starts_word ? static_cast<char>(std::toupper(static_cast<unsigned char>(c))) : c;
    starts_word = c == '_';
  }
  return out;
}

std::string filled_in(std::string_view text, const std::string& name) {
  const std::pair<std::string_view, std::string> marks[] = {{"@name@", name}, {"@Name@", class_name(name)}};
  std::string out(text);
  for (const auto& [mark, value] : marks) {
    for (std::size_t at = out.find(mark); at != std::string::npos; at = out.find(mark, at + value.size()))
      out.replace(at, mark.size(), value);
  }
  return out;
}

/// All files, or none if one is there already.
void write_project(const NewOptions& options) {
  const std::filesystem::path folder = options.folder.empty() ? options.name : options.folder;
  std::vector<std::pair<std::filesystem::path, std::string>> files;
  for (const TemplateFile& file : plugin_templates()) {
    if (file.kind != options.kind) continue;
    files.emplace_back(folder / filled_in(file.name, options.name), filled_in(file.text, options.name));
    if (std::filesystem::exists(std::filesystem::symlink_status(files.back().first)))
      throw Error(fmt::format("{}: exists already; nothing was written", files.back().first.string()));
  }
  create_folder(folder);
  for (const auto& [file, text] : files) {
    write_file(file, text, Belongs::to_nobody);
    print_output("{}\n", file.string());
  }
  // What finds this waymark: the folder that it is installed in.
  const std::filesystem::path prefix = std::filesystem::read_symlink("/proc/self/exe").parent_path().parent_path();
  const bool is_installed = std::filesystem::exists(prefix / "lib/cmake/waymark/waymark-config.cmake");
  const std::string build = (folder / "build").string();
  print_output(
      "\nBuild it, check it with the contract kit, run it:\n"
      "  cmake -S {0} -B {1} -DCMAKE_PREFIX_PATH={2}\n"
      "  cmake --build {1} && ctest --test-dir {1} --output-on-failure\n"
      "  WAYMARK_PLUGIN_PATH={1} waymark run {3} --out out/{4}\n",
      folder.string(), build, is_installed ? prefix.string() : "FOLDER_OF_THE_INSTALLED_WAYMARK",
      (folder / "robot.yaml").string(), options.name);
}

}  // namespace

void add_new_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<NewOptions>();
  CLI::App* command =
      app.add_subcommand("new", "Write the project of a new plugin, which compiles, runs and passes the contract kit");
  command->footer(
      "Example:\n  waymark new sensor wheel_slip\n  waymark new map-module door_map --into ~/plugins/doors");
  command->add_option("kind", options->kind, "what the plugin is")
      ->required()
      ->check(CLI::IsMember({"sensor", "map-module", "source", "sink"}));
  command->add_option("name", options->name, "its name in a YAML: small letters, digits and _")->required();
  command->add_option("--into", options->folder, "the project's folder; without it, a new one of the plugin's name");
  command->callback([options, &exit_code] {
    require_good_name(options->name);
    require_unused_name(options->name);
    write_project(*options);
    exit_code = kSuccess;
  });
}

}  // namespace waymark::command
