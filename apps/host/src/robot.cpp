// SPDX-License-Identifier: Apache-2.0
#include "waymark/host/robot.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "live_clock.hpp"
#include "live_input.hpp"
#include "merged_source.hpp"
#include "paced_log.hpp"
#include "waymark/base/error.hpp"
#include "waymark/interface/command.hpp"
#include "waymark/interface/map_module.hpp"

namespace waymark::host {

namespace {

Rig read_rig(const std::vector<Config>& entries) {
  std::vector<Mounting> mountings;
  std::set<std::string> names;
  for (const Config& entry : entries) {
    mountings.push_back(read_mounting(entry));
    const Mounting& mounting = mountings.back();
    if (!names.insert(mounting.name).second)
      entry.fail("name", fmt::format("\"{}\" is the name of two sensors", mounting.name));
    if (!entry.has("plugin") && mounting.payload.empty())
      entry.fail("a sensor needs a plugin, or a payload if only maps use it");
  }
  return Rig(std::move(mountings));
}

std::vector<SensorSlot> load_sensors(const std::vector<Config>& entries, const PluginLoader& loader, const Rig& rig,
                                     const OwnSensors& own) {
  std::vector<SensorSlot> slots;
  for (const Config& entry : entries) {
    SensorSlot slot = read_sensor_slot(entry);
    const auto mine = std::ranges::find(own, slot.plugin, &OwnSensors::value_type::first);
    if (!slot.enabled) {
      entry.ignore();
    } else if (mine != own.end()) {
      slot.sensor = mine->second;
      entry.ignore();
    } else if (!slot.plugin.empty()) {
      slot.sensor = loader.create<Sensor>(slot.plugin, entry, rig);
    }
    slots.push_back(std::move(slot));
  }
  return slots;
}

std::vector<MapSlot> load_maps(const Config& yaml, const PluginLoader& loader, const Rig& rig,
                               const std::vector<SensorSlot>& sensors) {
  std::vector<MapSlot> slots;
  std::set<std::string> names;
  for (const Config& entry :
       yaml.items_or_empty({"maps", "", "map modules; without any the host is a plain EKF", "none"})) {
    if (!entry.boolean({"enabled", "false: the map is left out, its keys are not checked"}, true)) {
      entry.ignore();
      continue;
    }
    MapSlot slot = read_map_slot(entry, rig);
    if (!names.insert(slot.name).second) entry.fail("name", fmt::format("\"{}\" is the name of two maps", slot.name));
    const SensorSlot& trigger = sensors[static_cast<std::size_t>(slot.inputs.front())];
    if (!trigger.enabled)
      entry.fail("inputs", fmt::format("its first sensor, \"{}\", is switched off (enabled: false)", trigger.name));
    slot.module = loader.create<MapModule>(slot.plugin, entry, rig);
    slots.push_back(std::move(slot));
  }
  normalize_shares(slots, yaml);
  return slots;
}

std::vector<int> connect(const Source& source, const Config& yaml, const Rig& rig,
                         const std::vector<SensorSlot>& sensors) {
  std::vector<int> sensor_of_channel;
  std::vector<bool> fed(sensors.size(), false);
  for (const Channel& channel : source.channels()) {
    if (channel.sensor.empty() && channel.payload_type == Command::kType) {
      sensor_of_channel.push_back(Robot::kCommands);
      continue;
    }
    const int sensor = rig.find(channel.sensor);
    if (sensor < 0)
      yaml.fail("source", fmt::format("it feeds \"{}\", which is not a sensor of this file", channel.sensor));
    const Mounting& mounting = rig.mountings()[static_cast<std::size_t>(sensor)];
    if (!mounting.payload.empty() && mounting.payload != channel.payload_type) {
      yaml.fail("source", fmt::format("it feeds sensor \"{}\" with {}, but the sensor takes {}", channel.sensor,
                                      channel.payload_type, mounting.payload));
    }
    fed[static_cast<std::size_t>(sensor)] = true;
    sensor_of_channel.push_back(sensors[static_cast<std::size_t>(sensor)].enabled ? sensor : -1);
  }
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    if (sensors[i].enabled && !fed[i])
      yaml.fail("sensors", fmt::format("the source delivers nothing for sensor \"{}\"", sensors[i].name));
  }
  return sensor_of_channel;
}

std::vector<SinkSlot> load_sinks(const Config& yaml, const PluginLoader& loader, const Rig& rig) {
  std::vector<SinkSlot> slots;
  for (const Config& entry :
       yaml.items_or_empty({"sinks", "", "what is written: `plugin`, `enabled` and the keys of the plugin", "none"})) {
    if (!entry.boolean({"enabled", "false: the sink is left out, its keys are not checked"}, true)) {
      entry.ignore();
      continue;
    }
    const std::string plugin = entry.text({"plugin", "name of the sink's plugin"});
    slots.push_back({plugin, loader.create<Sink>(plugin, entry, rig)});
  }
  const Config::Key record{"record", "", "the flight record: `{}`, or the keys of the sink `recorder`", "none"};
  if (yaml.has(record)) slots.push_back({"recorder", loader.create<Sink>("recorder", yaml.child(record), rig)});
  return slots;
}

/// The sink of the report, unless the YAML switches it off, or lists one of its own.
std::shared_ptr<Sink> load_report(const Config& yaml, const PluginLoader& loader, const Rig& rig,
                                  const std::vector<SinkSlot>& sinks) {
  const Config entry =
      yaml.child_or_empty({"report", "the page `report.html` that a run leaves: keys of the sink `report`"});
  const bool is_wanted = entry.boolean({"enabled", "false: there is no report"}, true);
  const bool is_installed = std::ranges::any_of(loader.folders(), [](const std::filesystem::path& folder) {
    std::error_code ignored;
    return std::filesystem::exists(folder / "waymark_report.so", ignored);
  });
  if (!is_wanted || !is_installed || std::ranges::any_of(sinks, [](const auto& s) { return s.plugin == "report"; })) {
    entry.ignore();
    return nullptr;
  }
  return loader.create<Sink>("report", entry, rig);
}

/// The YAML as it was named, for messages: `Config::file` is elsewhere if it has a `base_folder`.
std::string name_of(const Config& yaml) {
  const std::string place = yaml.place();  // with line and column
  return place.substr(0, place.rfind(':', place.rfind(':') - 1));
}

/// `Config::file` uses it; here it is declared and read.
void read_base_folder(const Config& yaml) {
  const Config::Key key{"base_folder", "",
                        "folder from which relative paths in this file count; the `config.yaml` of a run names that of "
                        "the file that was run",
                        "the folder of this file"};
  if (yaml.has(key)) yaml.text(key);
}

std::vector<std::filesystem::path> plugin_path(const Config& yaml) {
  std::vector<std::filesystem::path> folders;
  for (const std::string& folder : yaml.texts(
           {"plugin_path", "", "folder or list of folders with plugins, searched first; relative to the YAML", "none"},
           std::vector<std::string>{})) {
    const std::filesystem::path path(folder);
    folders.push_back(path.is_absolute() ? path : yaml.file().parent_path() / path);
  }
  return folders;
}

using SourceObjects = std::vector<std::shared_ptr<Source>>;

/// The sources of the YAML, in their order.
SourceObjects make_sources(const Config& yaml, const PluginLoader& loader, const Rig& rig) {
  const Config::Key one{"source", "where the measurements come from: `plugin` and the keys of the plugin"};
  const Config::Key several{"sources", "", "several sources, logs or live, instead of `source`; each as `source`",
                            "none"};
  std::vector<Config> entries;
  if (yaml.has(several)) {
    if (yaml.has("source")) yaml.fail("sources", "there is a `source`, too; give one of them");
    entries = yaml.items(several);
    if (entries.empty()) yaml.fail("sources", "the list is empty");
  } else {
    entries = {yaml.child(one)};
  }
  SourceObjects sources;
  sources.reserve(entries.size());
  for (const Config& entry : entries)
    sources.push_back(loader.create<Source>(entry.text({"plugin", "name of the source's plugin"}), entry, rig));
  return sources;
}

/// A pose as the value of `base_T_sensor`.
std::string mounting_text(const Pose& T_base_sensor) {
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  const Eigen::Matrix3d R = T_base_sensor.q.toRotationMatrix();
  const Eigen::Vector3d& p = T_base_sensor.p;
  const double pitch = std::asin(std::clamp(-R(2, 0), -1.0, 1.0));
  return fmt::format("{{ xyz_m: [{}, {}, {}], roll_deg: {}, pitch_deg: {}, yaw_deg: {} }}", p.x(), p.y(), p.z(),
                     kDegrees * std::atan2(R(2, 1), R(2, 2)), kDegrees * pitch,
                     kDegrees * std::atan2(R(1, 0), R(0, 0)));
}

/// Loads the plugins of a list, also of those that are switched off: a source may deliver a payload that one of them
/// registers. One that cannot be loaded is reported where it is used.
template <class Interface>
void load_plugins(const Config& yaml, const char* list, const PluginLoader& loader) {
  if (!yaml.is_list(list)) return;
  for (const Config& entry : yaml.items(list)) {
    if (!entry.has("plugin")) continue;
    try {
      loader.load<Interface>(entry.text("plugin"), entry);
    } catch (const PluginError&) {
      continue;
    }
  }
}

/// The entries of `sensors:` that leave the mounting to the robot.
std::vector<Config> entries_mounted_by_robot(const Config& yaml) {
  if (!yaml.is_list("sensors")) return {};  // load_parts reports it
  std::vector<Config> open = yaml.items("sensors");
  std::erase_if(open, [](const Config& entry) { return !is_mounted_by_source(entry); });
  return open;
}

/// Puts the numbers in the place of `base_T_sensor: from_tf`, so that they are part of the configuration and of every
/// record of the run. Returns the sources, which that needs.
SourceObjects settle_mountings(const std::vector<Config>& open, const Config& yaml, const PluginLoader& loader) {
  SourceObjects sources = make_sources(yaml, loader, read_rig(yaml.items("sensors")));
  for (const Config& entry : open) {
    if (!entry.boolean("enabled", true)) continue;
    std::optional<Pose> T_base_sensor;
    try {
      for (const std::shared_ptr<Source>& source : sources) {
        if (!T_base_sensor) T_base_sensor = source->T_base_sensor(entry.text("name"));
      }
    } catch (const DataError& error) {
      entry.fail("base_T_sensor", error.what());
    }
    if (!T_base_sensor) entry.fail("base_T_sensor", "from_tf: no source learns from the robot where it is mounted");
    entry.replace("base_T_sensor", mounting_text(*T_base_sensor));
  }
  return sources;
}

/// Everything but the sources and, without `with_sinks`, the sinks.
Robot load_parts(const Config& yaml, const PluginLoader& loader, const OwnSensors& own, bool with_sinks = true) {
  read_base_folder(yaml);
  const FusionSettings settings = read_fusion_settings(yaml);
  const std::vector<Config> entries = yaml.items({"sensors",
                                                  "at least one must be a motion source, unless `motion.source` is "
                                                  "`maps`; equal stamps are processed in the order of this list"});
  if (entries.empty()) yaml.fail("sensors", "the list is empty; a robot needs at least one motion source");
  LiveSettings live = read_live_settings(yaml);
  Rig rig = read_rig(entries);
  for (const std::string& name : live.may_drop) {
    if (rig.find(name) < 0) yaml.child("live").fail("may_drop", fmt::format("there is no sensor \"{}\"", name));
  }
  std::vector<SensorSlot> sensors = load_sensors(entries, loader, rig, own);
  std::vector<MapSlot> maps = load_maps(yaml, loader, rig, sensors);
  std::vector<SinkSlot> sinks;
  std::shared_ptr<Sink> report;
  if (with_sinks) {
    sinks = load_sinks(yaml, loader, rig);
    report = load_report(yaml, loader, rig, sinks);
  }
  Robot robot{yaml, std::move(rig),   settings,       std::move(sensors), std::move(maps), nullptr,
              {},   std::move(sinks), std::move(live)};
  robot.report = std::move(report);
  robot.is_diagnosed =
      yaml.child_or_empty({"diagnosis", "", "cross-checks of the sensors (docs/doctor.md)", "defaults"})
          .boolean({"enabled", "false: the sensors are not compared with each other"}, true);
  return robot;
}

/// Old names of keys that the YAML uses: they are read only where the new name is not given.
std::vector<std::string> old_names(const Config& yaml) {
  std::vector<std::string> found;
  for (const Config::Asked& asked : yaml.asked()) {
    const bool is_read = asked.type != Config::Asked::Type::none;
    if (is_read && asked.meaning.starts_with("old name of ")) found.push_back(asked.path + ": " + asked.meaning);
  }
  return found;
}

/// The sources as one: logs merged, or all of a running robot.
void join_sources(Robot& robot, SourceObjects sources) {
  const bool is_live =
      robot.live_settings.real_time || std::ranges::any_of(sources, [](const auto& s) { return s->is_live(); });
  if (is_live) {
    const auto simulation =
        std::ranges::find_if(sources, [](const auto& s) { return s->simulated_time().has_value(); });
    robot.live_clock = std::make_shared<LiveClock>(simulation == sources.end() ? nullptr : *simulation);
    for (std::shared_ptr<Source>& source : sources) {
      if (!source->is_live()) source = std::make_shared<PacedLog>(source, robot.live_clock);
    }
    robot.live_input = std::make_shared<LiveInput>(std::move(sources), robot.live_clock);
    robot.source = robot.live_input;
  } else {
    robot.source = sources.size() == 1 ? sources.front() : std::make_shared<MergedSource>(std::move(sources));
  }
}

}  // namespace

PluginLoader plugin_loader(const Config& yaml) {
  return PluginLoader(PluginLoader::standard_search_path(plugin_path(yaml)));
}

Robot Robot::load(const std::filesystem::path& file, const std::vector<Config::Override>& overrides) {
  const Config yaml = Config::load(file, overrides);
  return load(yaml, plugin_loader(yaml));
}

namespace {

/// Spatial motion whose height nothing observes.
bool leaves_height_free(const Robot& robot) {
  const auto observes = [](const SensorSlot& slot) {
    return slot.enabled && slot.sensor && slot.sensor->traits().observes_height;
  };
  const auto matches = [](const MapSlot& slot) { return slot.localize && slot.module && slot.module->is_spatial(); };
  return robot.settings.motion == StateLayout::Motion::spatial && std::ranges::none_of(robot.sensors, observes) &&
         std::ranges::none_of(robot.maps, matches);
}

}  // namespace

Robot Robot::load(const Config& yaml, const PluginLoader& loader, Mountings mountings) {
  load_plugins<Sensor>(yaml, "sensors", loader);
  load_plugins<MapModule>(yaml, "maps", loader);
  const std::vector<Config> open = entries_mounted_by_robot(yaml);
  SourceObjects sources;
  if (mountings == Mountings::assumed) {
    for (const Config& entry : open) entry.replace("base_T_sensor", mounting_text(Pose{}));
  } else if (!open.empty()) {
    sources = settle_mountings(open, yaml, loader);
  }
  Robot robot = load_parts(yaml, loader, {});
  // Who did not write the YAML should know that it brings code.
  for (const std::filesystem::path& folder : plugin_path(yaml)) {
    robot.settings.notices.push_back(
        fmt::format("plugin_path of the YAML: plugins are searched in {} first", folder.string()));
  }
  if (sources.empty()) sources = make_sources(yaml, loader, robot.rig);
  join_sources(robot, std::move(sources));
  std::ranges::move(old_names(yaml), std::back_inserter(robot.settings.notices));
  if (leaves_height_free(robot)) {
    robot.settings.notices.emplace_back(
        "motion.kind: spatial: nothing observes the height, which drifts freely; wheels, GNSS, an altimeter or a map "
        "with match.kind: spatial would, or use motion.kind: planar");
  }
  yaml.reject_unread();
  robot.sensor_of_channel = connect(*robot.source, yaml, robot.rig, robot.sensors);
  robot.loader = std::make_shared<const PluginLoader>(loader);
  // Only the parts together show whether they fit: a motion source, room for the blocks.
  robot.fusion(nullptr);
  if (mountings == Mountings::assumed) {
    for (const Config& entry : open) {
      entry.replace("base_T_sensor", "from_tf");
      robot.mounted_by_robot.push_back(entry.text("name"));
    }
  }
  return robot;
}

Robot Robot::live(const Config& yaml, const PluginLoader& loader, const OwnSensors& own) {
  Robot robot = load_parts(yaml, loader, own);
  if (yaml.has("source")) yaml.child("source").ignore();
  if (yaml.has("sources")) {
    for (const Config& entry : yaml.items("sources")) entry.ignore();
  }
  yaml.reject_unread();
  robot.loader = std::make_shared<const PluginLoader>(loader);
  return robot;
}

Robot Robot::retuned(const Config::Override& key_and_value) const {
  const bool is_of_parts = key_and_value.starts_with("sensors.") || key_and_value.starts_with("maps.");
  if (!is_of_parts || key_and_value.find('=') == std::string::npos)
    throw Error(fmt::format("\"{}\": sensors.NAME.KEY=VALUE or maps.NAME.KEY=VALUE is expected", key_and_value));
  if (!loader) throw Error("the robot was put together without a loader of plugins");
  // The name keeps the folder from which relative paths count.
  const std::string name = fmt::format("{} (effective)", name_of(yaml));
  const Config tuned = Config::parse(yaml.effective(), name, {key_and_value});
  for (const char* key : {"source", "sources", "sinks", "record", "report"}) {
    if (tuned.is_mapping(key)) tuned.child(key).ignore();
    if (!tuned.is_list(key)) continue;
    for (const Config& entry : tuned.items(key)) entry.ignore();
  }
  Robot parts = load_parts(tuned, *loader, {}, false);
  plugin_path(tuned);  // read, or it would count as unknown
  tuned.reject_unread();
  const auto same_part = [](const auto& a, const auto& b) { return a.name == b.name && a.plugin == b.plugin; };
  const bool is_same_robot =
      std::ranges::equal(parts.sensors, sensors,
                         [&](const SensorSlot& a, const SensorSlot& b) {
                           return same_part(a, b) && a.enabled == b.enabled &&
                                  (!a.sensor || std::ranges::equal(a.sensor->block(), b.sensor->block(), {},
                                                                   &BlockState::name, &BlockState::name));
                         }) &&
      std::ranges::equal(parts.maps, maps,
                         [&](const MapSlot& a, const MapSlot& b) { return same_part(a, b) && a.inputs == b.inputs; });
  if (!is_same_robot)
    throw Error(
        fmt::format("\"{}\": names, plugins, inputs and states cannot be changed while it runs", key_and_value));
  parts.fusion(nullptr);  // only the parts together show whether they fit
  Robot robot = *this;
  robot.adopt(std::move(parts));
  return robot;
}

/// Not the rig: sinks have been given this one, and names and payloads are the same.
void Robot::adopt(Robot&& retuned) {
  yaml = std::move(retuned.yaml);
  settings = std::move(retuned.settings);
  sensors = std::move(retuned.sensors);
  maps = std::move(retuned.maps);
}

std::unique_ptr<Fusion> Robot::fusion(Fusion::Observer observer) const {
  try {
    return std::make_unique<Fusion>(settings, sensors, maps, std::move(observer));
  } catch (const ConfigError& error) {
    throw ConfigError(fmt::format("{}: {}", name_of(yaml), error.what()));
  }
}

bool Robot::assign(Measurement& measurement) const {
  const int sensor = sensor_of_channel[measurement.sensor];
  if (sensor < 0) return false;
  measurement.sensor = static_cast<std::uint32_t>(sensor);
  return true;
}

}  // namespace waymark::host
