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

/// Sensors that a program brings itself, each by the name of the plugin that it replaces.
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
  std::shared_ptr<Source> source;      ///< null if the program itself delivers the measurements
  std::vector<int> sensor_of_channel;  ///< of the source; -1: the sensor is switched off
  std::vector<SinkSlot> sinks;

  /// Reads a file; plugins are looked for in its `plugin_path`, then where PluginLoader::standard_search_path looks.
  /// Throws ConfigError, PluginError or DataError: one line that says what is wrong and where.
  static Robot load(const std::filesystem::path& file, const std::vector<Config::Override>& overrides = {});
  /// The same for a YAML that was read already, with plugins from the folders of `loader` alone.
  static Robot load(const Config& yaml, const PluginLoader& loader);
  /// A robot to which the program itself delivers measurements: `source:` is not needed, and ignored if it is there.
  /// Whether the parts fit is only checked by `fusion`, so that the program can add its own before. Throws like `load`.
  static Robot live(const Config& yaml, const PluginLoader& loader, const OwnSensors& own = {});

  /// The filter of this robot. Throws ConfigError if the parts do not fit, with the name of the YAML.
  std::unique_ptr<Fusion> fusion(Fusion::Observer observer) const;

  /// Assigns a measurement of a channel of the source to its sensor; false if that is switched off.
  bool assign(Measurement& measurement) const;
};

}  // namespace waymark::host
