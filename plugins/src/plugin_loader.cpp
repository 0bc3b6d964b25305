// SPDX-License-Identifier: Apache-2.0
#include "waymark/plugin_loader.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <exception>
#include <map>
#include <system_error>

#include "plugin_file.hpp"
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

// The file of each name that `create` would take, sorted by name: the first that is not a dangling link.
std::vector<std::filesystem::path> plugin_files(const std::vector<std::filesystem::path>& folders) {
  std::map<std::string, std::filesystem::path> by_name;
  for (const auto& folder : folders) {
    for (const auto& file : plugin_files(folder)) {
      const auto [known, is_new] = by_name.emplace(plugin_name_of(file), file);
      if (!is_new && !dangling_link(known->second).empty() && dangling_link(file).empty()) known->second = file;
    }
  }
  std::vector<std::filesystem::path> files;
  files.reserve(by_name.size());
  for (const auto& [name, file] : by_name) files.push_back(file);
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

// For a sensor that only maps use, and that therefore has no plugin; empty for others.
std::string without_plugin(std::string_view kind, std::string_view name) {
  if (kind != "sensor") return {};
  std::string_view payload;
  if (name == "lidar" || name == "laser" || name == "scanner" || name == "LaserScan") payload = "LaserScan";
  if (name == "PointCloud") payload = "PointCloud";
  if (name == "camera" || name == "Image") payload = "Image";
  if (payload.empty()) return {};
  return fmt::format("; a scanner or a camera has no plugin: write payload: {} instead", payload);
}

std::filesystem::path find_file(std::string_view kind, std::string_view name,
                                const std::vector<std::filesystem::path>& folders) {
  if (!is_plain_name(name)) {
    throw PluginError(fmt::format("plugin \"{}\": a plugin's name has only letters, digits, _ and -", name));
  }
  const std::string file_name = fmt::format("waymark_{}.so", name);
  for (const auto& folder : folders) {
    std::error_code error;
    if (std::filesystem::exists(folder / file_name, error)) return folder / file_name;
  }
  for (const auto& folder : folders) {
    if (const auto link = dangling_link(folder / file_name); !link.empty()) {
      throw PluginError(fmt::format("plugin \"{}\" is not found: {} {}", name, (folder / file_name).string(), link));
    }
  }
  std::vector<std::string> names;
  for (const auto& file : plugin_files(folders)) names.push_back(plugin_name_of(file));
  const std::string nearest = nearest_name(name, names);
  const std::string hint = without_plugin(kind, name);
  throw PluginError(
      fmt::format("plugin \"{}\" is not found: no {} in {}{}", name, file_name, describe(folders),
                  hint.empty() && !nearest.empty() ? fmt::format("; did you mean \"{}\"?", nearest) : hint));
}

// Loads the file only if its record fits.
PluginLibrary open_fitting(const std::filesystem::path& file, std::string_view kind, std::string_view name) {
  const PluginRecord record = read_plugin_record(file);
  if (const auto problem = misfit(record); !problem.empty()) {
    throw PluginError(fmt::format("{}: {}", file.string(), problem));
  }
  if (const auto its_kind = record_text(record.kind); kind != its_kind) {
    throw PluginError(
        fmt::format("{}: is a plugin of kind \"{}\", but a \"{}\" is asked for", file.string(), its_kind, kind));
  }
  if (const auto its_name = record_text(record.name); name != its_name) {
    throw PluginError(
        fmt::format("{}: calls itself \"{}\", but its file name says \"{}\"", file.string(), its_name, name));
  }
  return open_plugin_library(file, record);
}

// Where in the YAML the plugin was asked for, as ConfigError does it.
std::string origin(const Config& config) {
  const std::string path = config.path();
  return path.empty() ? config.place() : fmt::format("{}: {}", config.place(), path);
}

// The library that a node of the YAML asks for.
PluginLibrary open_for(std::string_view kind, std::string_view name, const Config& config,
                       const std::vector<std::filesystem::path>& folders) {
  try {
    return open_fitting(find_file(kind, name, folders), kind, name);
  } catch (const PluginError& error) {
    throw PluginError(fmt::format("{}: {}", origin(config), error.what()));
  }
}

}  // namespace

PluginLoader::PluginLoader(std::vector<std::filesystem::path> folders) : folders_(std::move(folders)) {}

std::shared_ptr<void> PluginLoader::create_erased(std::string_view kind, std::string_view name, const Config& config,
                                                  const Rig& rig, void (*destroy)(void*)) const {
  const PluginLibrary library = open_for(kind, name, config, folders_);
  void* object = nullptr;
  try {
    object = library.descriptor->create(config, rig);
  } catch (const ConfigError& error) {
    // What the rig throws names its key, but neither file nor line.
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

void PluginLoader::load_library(std::string_view kind, std::string_view name, const Config& config) const {
  open_for(kind, name, config, folders_);
}

std::vector<PluginInfo> PluginLoader::list() const {
  std::vector<PluginInfo> infos;
  for (const auto& file : plugin_files(folders_)) {
    PluginInfo info{file, "", plugin_name_of(file), "", ""};
    try {
      const PluginRecord record = read_plugin_record(file);
      info.problem = misfit(record);
      if (info.problem.empty()) {
        info.kind = record_text(record.kind);
        info.version = record_text(record.version);
        if (const auto name = record_text(record.name); info.name != name) {
          info.problem = fmt::format("calls itself \"{}\"", name);
        }
      }
    } catch (const PluginError& error) {
      info.problem = error.what();
    }
    infos.push_back(std::move(info));
  }
  return infos;
}

}  // namespace waymark
