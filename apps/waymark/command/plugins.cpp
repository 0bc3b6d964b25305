// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "apps/waymark/command/commands.hpp"
#include "waymark/base/error.hpp"
#include "waymark/config/nearest_name.hpp"
#include "waymark/host/reference.hpp"
#include "waymark/plugin_loader.hpp"

namespace waymark::command {

namespace {

void list_plugins(const PluginLoader& loader) {
  fmt::print("searched:\n");
  for (const auto& folder : loader.folders()) fmt::print("  {}\n", folder.string());
  const std::vector<PluginInfo> plugins = loader.list();
  fmt::print("\n{:<12} {:<16} {:<9} {}\n", "kind", "name", "version", "file");
  for (const PluginInfo& plugin : plugins) {
    fmt::print("{:<12} {:<16} {:<9} {}\n", plugin.kind, plugin.name, plugin.version, plugin.file.string());
    if (!plugin.problem.empty()) fmt::print("    does not fit: {}\n", plugin.problem);
  }
  if (plugins.empty()) fmt::print("none\n");
}

PluginInfo find_plugin(const PluginLoader& loader, const std::string& name) {
  std::vector<std::string> names;
  for (const PluginInfo& plugin : loader.list()) {
    if (plugin.name == name) {
      if (plugin.problem.empty()) return plugin;
      throw PluginError(fmt::format("plugin \"{}\" does not fit: {}", name, plugin.problem));
    }
    names.push_back(plugin.name);
  }
  const std::string near = nearest_name(name, names);
  throw PluginError(fmt::format("there is no plugin \"{}\"{}; there are: {}", name,
                                near.empty() ? "" : fmt::format("; did you mean \"{}\"?", near),
                                fmt::join(names, ", ")));
}

void print_keys(const std::vector<DescribedKey>& keys) {
  for (const DescribedKey& key : keys) {
    const Config::Asked& asked = key.asked;
    if (asked.meaning.empty()) continue;  // of the host, or only looked for
    const std::string unit = asked.unit.empty() ? "" : fmt::format(" [{}]", asked.unit);
    const std::string fallback = asked.is_required ? ", required"
                                 : asked.fallback  ? fmt::format(", default {}", *asked.fallback)
                                                   : "";
    fmt::print("  {}{}: {}{}\n", asked.path, unit, asked.expectation(), fallback);
    fmt::print("      {}\n", asked.meaning);
  }
}

/// What to print.
struct Request {
  std::string name;        ///< a plugin, or "robot"
  bool markdown = false;   ///< as a table
  std::string block = {};  ///< only of keys right below this one; "." for the top level
  std::string below = {};  ///< only of keys anywhere below this one
};

void print_reference(const PluginLoader& loader, const Request& request) {
  const bool of_robot = request.name == "robot";
  const PluginInfo plugin = of_robot ? PluginInfo{} : find_plugin(loader, request.name);
  const std::vector<DescribedKey> keys = of_robot ? host::robot_keys() : host::plugin_keys(loader, plugin);
  if (request.markdown) {
    const std::string& block = request.block.empty() ? request.below : request.block;
    fmt::print("{}", host::key_table(keys, block == "." ? "" : block, request.block.empty()));
    return;
  }
  if (!of_robot) fmt::print("{} {} {}, {}\n", plugin.kind, plugin.name, plugin.version, plugin.file.string());
  print_keys(keys);
}

}  // namespace

void add_plugins_command(CLI::App& app, int& exit_code) {
  auto folders = std::make_shared<std::vector<std::string>>();
  auto request = std::make_shared<Request>();
  CLI::App* command = app.add_subcommand("plugins", "List the plugins that are found, and where; or the keys of one");
  command->footer("Example:\n  waymark plugins dgps");
  command->add_option("name", request->name, "a plugin whose keys are listed; \"robot\": the keys outside of plugins");
  command->add_option("--path", *folders, "folders to look in before the usual ones");
  CLI::Option* table = command->add_flag("--markdown", request->markdown, "the keys as a table");
  CLI::Option* block =
      command->add_option("--block", request->block, "only the keys right below this one; \".\": of the top level");
  command->add_option("--below", request->below, "only the keys anywhere below this one")
      ->needs(table)
      ->excludes(block);
  block->needs(table);
  command->callback([folders, request, &exit_code] {
    const PluginLoader loader(PluginLoader::standard_search_path({folders->begin(), folders->end()}));
    if (request->name.empty()) {
      list_plugins(loader);
    } else {
      print_reference(loader, *request);
    }
    exit_code = kSuccess;
  });
}

}  // namespace waymark::command
