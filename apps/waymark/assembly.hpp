// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "waymark/host/fusion_settings.hpp"
#include "waymark/interface/rig.hpp"
#include "waymark/interface/sink.hpp"
#include "waymark/interface/source.hpp"
#include "waymark/plugin_loader.hpp"

namespace waymark {

/// One sink of the YAML.
struct SinkSlot {
  std::string plugin;
  std::shared_ptr<Sink> sink;
};

/// A robot put together from one YAML: every part is loaded and valid, every key was read.
struct Assembly {
  Config yaml;
  PluginLoader loader;
  Rig rig;
  FusionSettings settings;
  std::vector<SensorSlot> sensors;
  std::vector<MapSlot> maps;
  std::shared_ptr<Source> source;
  std::vector<int> sensor_of_channel;  ///< -1: the sensor is switched off
  std::vector<SinkSlot> sinks;

  /// Throws ConfigError, PluginError or DataError: one line that says what is wrong and where.
  static Assembly load(const std::filesystem::path& file, const std::vector<Config::Override>& overrides);

  /// Makes the channel of a measurement of `source` the sensor that it is for; false if that is switched off.
  bool address(Measurement& measurement) const;
};

}  // namespace waymark
