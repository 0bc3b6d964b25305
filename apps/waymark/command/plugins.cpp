// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>
#include <string>
#include <vector>

#include "apps/waymark/command/command_line.hpp"
#include "apps/waymark/command/commands.hpp"
#include "waymark/base/error.hpp"
#include "waymark/config/nearest_name.hpp"
#include "waymark/host/reference.hpp"
#include "waymark/interface/payload_registry.hpp"
#include "waymark/plugin_inspection.hpp"
#include "waymark/plugin_loader.hpp"

namespace waymark::command {

namespace {

void list_plugins(const PluginLoader& loader) {
  print_output("searched:\n");
  for (const auto& folder : loader.folders()) print_output("  {}\n", folder.string());
  const std::vector<PluginInfo> plugins = loader.list();
  print_output("\n{:<12} {:<16} {:<9} {}\n", "kind", "name", "version", "file");
  for (const PluginInfo& plugin : plugins) {
    print_output("{:<12} {:<16} {:<9} {}\n", plugin.kind, plugin.name, plugin.version, plugin.file.string());
    if (!plugin.problem.empty()) print_output("    does not fit: {}\n", plugin.problem);
  }
  if (plugins.empty()) print_output("none\n");
}

/// A payload as it is registered.
struct PayloadFields {
  std::string name;
  std::string type;
  std::vector<FieldDescription> fields;
};

std::vector<PayloadFields> payloads() {
  std::vector<PayloadFields> all;
  for (const KnownPayload& known : known_payloads())
    all.push_back({std::string(short_type_name(known.type)), std::string(known.type), known.describe()});
  return all;
}

std::string names_of_payloads() {
  std::string names;
  for (const PayloadFields& payload : payloads()) names += (names.empty() ? "" : ", ") + payload.name;
  return names;
}

/// False if there is no payload of that name.
bool print_payload(const std::string& name) {
  for (const PayloadFields& payload : payloads()) {
    if (payload.name != name && payload.type != name) continue;
    print_output("payload {}\n", payload.type);
    for (const FieldDescription& field : payload.fields) {
      print_output("  {}{}: {}{}{}\n", field.name, field.info.unit.empty() ? "" : fmt::format(" [{}]", field.info.unit),
                   field.kind, field.info.required ? ", required" : "",
                   field.info.unknown.empty() ? "" : fmt::format(", not known: {}", field.info.unknown));
      print_output("      {}\n", field.info.meaning);
    }
    return true;
  }
  return false;
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
  for (const PayloadFields& payload : payloads()) names.push_back(payload.name);
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
    print_output("  {}{}: {}{}\n", asked.path, unit, asked.expectation(), fallback);
    print_output("      {}\n", asked.meaning);
  }
}

/// `name`: a plugin, or "robot".
void print_reference(const PluginLoader& loader, const std::string& name, bool markdown) {
  const bool of_robot = name == "robot";
  const PluginInfo plugin = of_robot ? PluginInfo{} : find_plugin(loader, name);
  const std::vector<DescribedKey> keys = of_robot ? host::robot_keys() : host::plugin_keys(loader, plugin);
  if (markdown) {
    print_output("{}", host::key_table(keys));
    return;
  }
  if (!of_robot) print_output("{} {} {}, {}\n", plugin.kind, plugin.name, plugin.version, plugin.file.string());
  print_keys(keys);
  // Those of this plugin: no other is loaded.
  for (const KnownPayload& known : known_payloads()) {
    if (!is_of_core(known.type)) print_payload(std::string(known.type));
  }
  if (plugin.kind == "source")
    print_output("payloads: {}; waymark plugins PAYLOAD lists the fields of one\n", names_of_payloads());
}

/// One line of what a file says about itself, with this program's value where it differs.
void print_compared(const char* what, const std::string& value, const std::string& ours) {
  print_output("{:<10} {}\n", what,
               value == ours ? value + " (as this program)" : value + "; this program has " + ours);
}

/// Prints all that a plugin's file says. Throws PluginError if the loader would refuse it.
void inspect(const std::string& file) {
  const PluginInspection found = inspect_plugin(file);
  print_output("{:<10} {}\n", "file", found.file.string());
  if (found.abi == kPluginAbi) {
    print_output("{:<10} {}\n{:<10} {}\n{:<10} {}\n", "kind", found.kind, "name", found.name, "version", found.version);
  }
  print_compared("ABI", std::to_string(found.abi), std::to_string(kPluginAbi));
  if (found.abi == kPluginAbi) {
    print_compared("build key", found.build_key, kBuildKey);
    print_compared("alignment", fmt::format("{} bytes", found.eigen_max_align),
                   fmt::format("{} bytes", EIGEN_MAX_ALIGN_BYTES));
  }
  if (!found.problem.empty()) throw PluginError(fmt::format("{}: {}", found.file.string(), found.problem));
  print_output("{:<10} yes; nothing of it was run\n", "fits");
}

void add_inspect_command(CLI::App& plugins, int& exit_code) {
  auto file = std::make_shared<std::string>();
  CLI::App* command = plugins.add_subcommand(
      "inspect", "Print what a plugin's file says about itself and whether it fits, without running any of it");
  command->footer(
      "Example:\n  waymark plugins inspect build/waymark_wheel_slip.so\n\n"
      "Ends with 1 if the file would be refused, and says why.");
  command->add_option("file", *file, "the shared library")->required();
  command->callback([file, &exit_code] {
    inspect(*file);
    exit_code = kSuccess;
  });
}

}  // namespace

void add_plugins_command(CLI::App& app, int& exit_code) {
  auto folders = std::make_shared<std::vector<std::string>>();
  auto name = std::make_shared<std::string>();
  auto markdown = std::make_shared<bool>(false);
  CLI::App* command = app.add_subcommand("plugins", "List the plugins that are found, and where; or the keys of one");
  command->footer("Example:\n  waymark plugins dgps\n  waymark plugins inspect build/waymark_wheel_slip.so");
  command->add_option(
      "name", *name,
      "a plugin whose keys are listed, or a payload and its fields; \"robot\": the keys outside of plugins");
  command->add_option("--path", *folders, "folders to look in before the usual ones");
  command->add_flag("--markdown", *markdown, "the keys as a table");
  add_inspect_command(*command, exit_code);
  command->callback([command, folders, name, markdown, &exit_code] {
    if (!command->get_subcommands().empty()) return;  // which has done its work
    const PluginLoader loader(PluginLoader::standard_search_path({folders->begin(), folders->end()}));
    if (name->empty()) {
      list_plugins(loader);
    } else if (!print_payload(*name)) {
      print_reference(loader, *name, *markdown);
    }
    exit_code = kSuccess;
  });
}

}  // namespace waymark::command
