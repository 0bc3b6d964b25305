// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <string>
#include <vector>

#include "apps/waymark/command/command_line.hpp"
#include "apps/waymark/command/commands.hpp"
#include "apps/waymark/command/config_schema.hpp"
#include "waymark/host/reference.hpp"
#include "waymark/plugin_loader.hpp"

namespace waymark::command {

void add_schema_command(CLI::App& app, int& exit_code) {
  auto folders = std::make_shared<std::vector<std::string>>();
  CLI::App* command = app.add_subcommand(
      "schema", "Print a JSON schema of configurations with all plugins that are found, for editors");
  command->footer(
      "Example:\n  waymark schema > waymark.schema.json\n\n"
      "A YAML names it in its first line: # yaml-language-server: $schema=waymark.schema.json");
  command->add_option("--path", *folders, "folders to look in before the usual ones");
  command->callback([folders, &exit_code] {
    const PluginLoader loader(PluginLoader::standard_search_path({folders->begin(), folders->end()}));
    std::vector<PluginKeys> plugins;
    for (const PluginInfo& plugin : loader.list()) {
      if (plugin.problem.empty()) plugins.push_back({plugin.kind, plugin.name, host::plugin_keys(loader, plugin)});
    }
    print_output("{}", config_schema(host::robot_keys(), plugins));
    exit_code = kSuccess;
  });
}

}  // namespace waymark::command
