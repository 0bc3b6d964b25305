// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "waymark/host/fusion.hpp"
#include "waymark/host/fusion_settings.hpp"
#include "waymark/interface/rig.hpp"
#include "waymark/interface/sink.hpp"
#include "waymark/interface/source.hpp"
#include "waymark/plugin_loader.hpp"

namespace waymark::host {

/// One sink of the YAML.
struct SinkSlot {
  std::string plugin;
  std::shared_ptr<Sink> sink;
};

/// Sensors provided by the program, each with the name of the plugin that it replaces.
using OwnSensors = std::vector<std::pair<std::string, std::shared_ptr<Sensor>>>;

/// Finds plugins where the YAML's `plugin_path`, the environment and the installation name folders.
PluginLoader plugin_loader(const Config& yaml);

/// A robot put together from one YAML: every part is loaded and valid, every key was read.
struct Robot {
  Config yaml;
  Rig rig;
  FusionSettings settings;
  std::vector<SensorSlot> sensors;
  std::vector<MapSlot> maps;
  std::shared_ptr<Source> source;      ///< null if the program adds the measurements
  std::vector<int> sensor_of_channel;  ///< of the source; -1: the sensor is disabled
  std::vector<SinkSlot> sinks;

  /// Reads a file. Plugins are searched in its `plugin_path`, then in the folders of
  /// `PluginLoader::standard_search_path`. Throws ConfigError, PluginError or DataError, with place and cause in one
  /// line.
  static Robot load(const std::filesystem::path& file, const std::vector<Config::Override>& overrides = {});
  /// Builds a robot from a YAML that is already read, with plugins from the folders of `loader` only.
  static Robot load(const Config& yaml, const PluginLoader& loader);
  /// Builds a robot whose measurements the program adds: `source:` is optional and ignored. Whether the parts fit
  /// together is checked by `fusion` only, so that the program can add its own before. Throws like `load`.
  static Robot live(const Config& yaml, const PluginLoader& loader, const OwnSensors& own = {});

  /// Creates the filter of this robot. Throws ConfigError with the name of the YAML if the parts do not fit together.
  std::unique_ptr<Fusion> fusion(Fusion::Observer observer) const;

  /// Replaces the channel of a source's measurement by the index of its sensor; false if that is disabled.
  bool assign(Measurement& measurement) const;
};

}  // namespace waymark::host
