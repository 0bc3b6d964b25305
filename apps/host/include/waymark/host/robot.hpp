// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "waymark/host/fusion.hpp"
#include "waymark/host/fusion_settings.hpp"
#include "waymark/host/live_settings.hpp"
#include "waymark/interface/rig.hpp"
#include "waymark/interface/sink.hpp"
#include "waymark/interface/source.hpp"
#include "waymark/plugin_loader.hpp"

namespace waymark::host {

class LiveClock;
class LiveInput;

/// One sink of the YAML.
struct SinkSlot {
  std::string plugin;
  std::shared_ptr<Sink> sink;
};

/// Sensors provided by the program, each with the name of the plugin that it replaces.
using OwnSensors = std::vector<std::pair<std::string, std::shared_ptr<Sensor>>>;

/// Finds plugins where the YAML's `plugin_path`, the environment and the installation name folders.
PluginLoader plugin_loader(const Config& yaml);

/// Where the mountings come from that the YAML leaves to the robot (`base_T_sensor: from_tf`).
enum class Mountings {
  from_robot,  ///< from the robot itself: its sources wait for them
  assumed      ///< all at base_link: a YAML is validated without its robot; `Robot::mounted_by_robot` lists them
};

/// A robot put together from one YAML: every part is loaded and valid, every key was read.
struct Robot {
  Config yaml;
  Rig rig;
  FusionSettings settings;
  std::vector<SensorSlot> sensors;
  std::vector<MapSlot> maps;
  /// All sources of the YAML as one; null if the program adds the measurements.
  std::shared_ptr<Source> source;
  std::vector<int> sensor_of_channel;  ///< of the source; -1: the sensor is disabled; kCommands
  std::vector<SinkSlot> sinks;
  LiveSettings live_settings = {};
  bool is_diagnosed = true;                          ///< `diagnosis.enabled`
  std::shared_ptr<LiveInput> live_input = {};        ///< the source, if one of the YAML's is live; else null
  std::shared_ptr<const LiveClock> live_clock = {};  ///< of its arrivals
  std::shared_ptr<const PluginLoader> loader = {};   ///< of its plugins
  std::vector<std::string> mounted_by_robot = {};    ///< sensors whose mounting is `Mountings::assumed`

  static constexpr int kCommands = -2;  ///< in `sensor_of_channel`: a channel of commands

  /// Reads a file. Plugins are searched in its `plugin_path`, then in the folders of
  /// `PluginLoader::standard_search_path`. Throws ConfigError, PluginError or DataError, with place and cause in one
  /// line.
  static Robot load(const std::filesystem::path& file, const std::vector<Config::Override>& overrides = {});
  /// Builds a robot from a YAML that is already read, with plugins from the folders of `loader` only.
  static Robot load(const Config& yaml, const PluginLoader& loader, Mountings mountings = Mountings::from_robot);
  /// Builds a robot whose measurements the program adds: `source:` is optional and ignored. Whether the parts fit
  /// together is checked by `fusion` only, so that the program can add its own before. Throws like `load`.
  static Robot live(const Config& yaml, const PluginLoader& loader, const OwnSensors& own = {});

  /// This robot with one key of a sensor or map changed: "sensors.gps.sigma_m=2", "maps.pillars.…". Its sensors and
  /// maps are new, in their initial state. Throws ConfigError or PluginError, and Error for a key that cannot be
  /// changed so.
  Robot retuned(const Config::Override& key_and_value) const;
  /// Takes configuration, settings, sensors and maps of another one, which `retuned` made.
  void adopt(Robot&& retuned);

  /// Creates the filter of this robot. Throws ConfigError with the name of the YAML if the parts do not fit together.
  std::unique_ptr<Fusion> fusion(Fusion::Observer observer) const;

  /// True if a source's measurement is a command.
  bool is_command(const Measurement& measurement) const { return sensor_of_channel[measurement.sensor] == kCommands; }
  /// Replaces the channel of a source's measurement by the index of its sensor; false if that is disabled, and for a
  /// command.
  bool assign(Measurement& measurement) const;
};

}  // namespace waymark::host
