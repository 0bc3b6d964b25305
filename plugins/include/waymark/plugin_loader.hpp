// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "waymark/plugin/descriptor.hpp"

namespace waymark {

/// Properties of a library that may be a plugin, read from its file. Nothing of the library runs.
struct PluginInfo {
  std::filesystem::path file;
  std::string kind;
  std::string name;
  std::string version;
  std::string problem;  ///< why it does not fit this host; empty if it does
};

/// Finds, checks and loads plugins. A library is loaded, and its static initialisers run, only after ABI, build key,
/// alignment, kind and name were read from its file and fit. It is loaded once and never unloaded; every object keeps
/// its library alive. Who creates objects includes the header of their interface.
class PluginLoader {
 public:
  /// Folders in the order of search. `standard_search_path` gives the usual ones.
  explicit PluginLoader(std::vector<std::filesystem::path> folders);

  /// `first` (the YAML's plugin_path), then the environment variable WAYMARK_PLUGIN_PATH (colon-separated), then the
  /// folder of the installation: `../lib/waymark/plugins` relative to the running program.
  static std::vector<std::filesystem::path> standard_search_path(std::vector<std::filesystem::path> first = {});

  /// Creates the object that `config` describes with plugin `name` (library `waymark_<name>.so`) of the kind of
  /// `Interface`. Throws PluginError: not found (with the folders searched and the nearest name), not a library or a
  /// truncated one, no descriptor, other ABI, build key, alignment, kind or name. Passes on an Error of the
  /// constructor; any other exception becomes a ConfigError at the node's place.
  template <class Interface>
  std::shared_ptr<Interface> create(std::string_view name, const Config& config, const Rig& rig) const {
    return std::static_pointer_cast<Interface>(create_erased(
        plugin_kind<Interface>(), name, config, rig, [](void* object) { delete static_cast<Interface*>(object); }));
  }

  /// Loads the library of a plugin, checked as by `create`, and creates nothing: its payloads are known then, to
  /// sources that are made before it. Throws PluginError.
  template <class Interface>
  void load(std::string_view name, const Config& config) const {
    load_library(plugin_kind<Interface>(), name, config);
  }

  /// All libraries `waymark_*.so` in the folders, sorted by name. Loads none of them.
  std::vector<PluginInfo> list() const;

  const std::vector<std::filesystem::path>& folders() const { return folders_; }

 private:
  std::shared_ptr<void> create_erased(std::string_view kind, std::string_view name, const Config& config,
                                      const Rig& rig, void (*destroy)(void*)) const;

  void load_library(std::string_view kind, std::string_view name, const Config& config) const;

  std::vector<std::filesystem::path> folders_;
};

}  // namespace waymark
