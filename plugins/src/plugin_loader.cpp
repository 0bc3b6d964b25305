// SPDX-License-Identifier: Apache-2.0
#include "waymark/plugin_loader.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <exception>
#include <set>
#include <system_error>

#include "plugin_library.hpp"
#include "waymark/config/nearest_name.hpp"

namespace waymark {
namespace {

// A name is part of a file name; a path in it would lead out of the folders.
bool is_plain_name(std::string_view name) {
  return !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-';
  });
}

std::vector<std::filesystem::path> plugin_files(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  std::error_code error;
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    if (!plugin_name_of(entry->path()).empty()) files.push_back(entry->path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

// The first file of each name, as `create` would take it, sorted by name.
std::vector<std::filesystem::path> plugin_files(const std::vector<std::filesystem::path>& folders) {
  std::vector<std::filesystem::path> files;
  std::set<std::string> names;
  for (const auto& folder : folders) {
    for (const auto& file : plugin_files(folder)) {
      if (names.insert(plugin_name_of(file)).second) files.push_back(file);
    }
  }
  std::sort(files.begin(), files.end(),
            [](const auto& a, const auto& b) { return plugin_name_of(a) < plugin_name_of(b); });
  return files;
}

std::string describe(const std::vector<std::filesystem::path>& folders) {
  std::vector<std::string> texts;
  for (const auto& folder : folders) {
    std::error_code error;
    const bool exists = std::filesystem::is_directory(folder, error);
    texts.push_back(exists ? folder.string() : fmt::format("{} (no such folder)", folder.string()));
  }
  return texts.empty() ? "no folder" : fmt::format("{}", fmt::join(texts, ", "));
}

std::filesystem::path find_file(std::string_view name, const std::vector<std::filesystem::path>& folders) {
  if (!is_plain_name(name)) {
    throw PluginError(fmt::format("plugin \"{}\": a plugin's name has only letters, digits, _ and -", name));
  }
  const std::string file_name = fmt::format("waymark_{}.so", name);
  for (const auto& folder : folders) {
    std::error_code error;
    if (std::filesystem::exists(folder / file_name, error)) return folder / file_name;
  }
  std::vector<std::string> names;
  for (const auto& file : plugin_files(folders)) names.push_back(plugin_name_of(file));
  const std::string nearest = nearest_name(name, names);
  throw PluginError(fmt::format("plugin \"{}\" is not found: no {} in {}{}", name, file_name, describe(folders),
                                nearest.empty() ? "" : fmt::format("; did you mean \"{}\"?", nearest)));
}

PluginLibrary open_fitting(const std::filesystem::path& file, std::string_view kind, std::string_view name) {
  PluginLibrary library = open_plugin_library(file);
  const PluginDescriptor& descriptor = *library.descriptor;
  if (const auto problem = misfit(descriptor); !problem.empty()) {
    throw PluginError(fmt::format("{}: {}", file.string(), problem));
  }
  if (kind != descriptor.kind) {
    throw PluginError(
        fmt::format("{}: is a plugin of kind \"{}\", but a \"{}\" is asked for", file.string(), descriptor.kind, kind));
  }
  if (name != descriptor.name) {
    throw PluginError(
        fmt::format("{}: calls itself \"{}\", but its file name says \"{}\"", file.string(), descriptor.name, name));
  }
  return library;
}

// Where in the YAML the plugin was asked for, as ConfigError does it.
std::string origin(const Config& config) {
  const std::string path = config.path();
  return path.empty() ? config.place() : fmt::format("{}: {}", config.place(), path);
}

}  // namespace

PluginLoader::PluginLoader(std::vector<std::filesystem::path> folders) : folders_(std::move(folders)) {}

std::shared_ptr<void> PluginLoader::create_erased(std::string_view kind, std::string_view name, const Config& config,
                                                  const Rig& rig, void (*destroy)(void*)) const {
  PluginLibrary library{};
  try {
    library = open_fitting(find_file(name, folders_), kind, name);
  } catch (const PluginError& error) {
    throw PluginError(fmt::format("{}: {}", origin(config), error.what()));
  }
  void* object = nullptr;
  try {
    object = library.descriptor->create(config, rig);
  } catch (const ConfigError& error) {
    // What the rig throws knows its key, but neither file nor line.
    if (!std::string_view(error.what()).starts_with("sensors.")) throw;
    config.fail(error.what());
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    config.fail(fmt::format("plugin \"{}\" could not be built: {}", name, error.what()));
  } catch (...) {
    config.fail(fmt::format("plugin \"{}\" could not be built: it threw something that is not a std::exception", name));
  }
  if (object == nullptr) config.fail(fmt::format("plugin \"{}\" could not be built: it returned nothing", name));
  return {object, [keep = library.handle, destroy](void* plugin) { destroy(plugin); }};
}

std::vector<PluginInfo> PluginLoader::list() const {
  std::vector<PluginInfo> infos;
  for (const auto& file : plugin_files(folders_)) {
    PluginInfo info{file, "", plugin_name_of(file), "", ""};
    try {
      const PluginDescriptor& descriptor = *open_plugin_library(file).descriptor;
      info.problem = misfit(descriptor);
      if (info.problem.empty()) {
        info.kind = descriptor.kind;
        info.version = descriptor.version;
        if (info.name != descriptor.name) info.problem = fmt::format("calls itself \"{}\"", descriptor.name);
      }
    } catch (const PluginError& error) {
      info.problem = error.what();
    }
    infos.push_back(std::move(info));
  }
  return infos;
}

}  // namespace waymark
