// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdio>
#include <memory>

#include "apps/waymark/command/commands.hpp"
#include "waymark/plugin_loader.hpp"

namespace waymark::command {

void add_plugins_command(CLI::App& app, int& exit_code) {
  auto folders = std::make_shared<std::vector<std::string>>();
  CLI::App* command = app.add_subcommand("plugins", "List the plugins that are found, and where");
  command->footer("Example:\n  waymark plugins --path build/release/lib/waymark/plugins");
  command->add_option("--path", *folders, "folders to look in before the usual ones");
  command->callback([folders, &exit_code] {
    const PluginLoader loader(PluginLoader::standard_search_path({folders->begin(), folders->end()}));
    fmt::print("searched:\n");
    for (const auto& folder : loader.folders()) fmt::print("  {}\n", folder.string());
    const std::vector<PluginInfo> plugins = loader.list();
    fmt::print("\n{:<12} {:<16} {:<9} {}\n", "kind", "name", "version", "file");
    for (const PluginInfo& plugin : plugins) {
      fmt::print("{:<12} {:<16} {:<9} {}\n", plugin.kind, plugin.name, plugin.version, plugin.file.string());
      if (!plugin.problem.empty()) fmt::print("    does not fit: {}\n", plugin.problem);
    }
    if (plugins.empty()) fmt::print("none\n");
    exit_code = kSuccess;
  });
}

}  // namespace waymark::command
