// SPDX-License-Identifier: Apache-2.0
#include "fusion/setup.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <ranges>
#include <string>
#include <string_view>
#include <utility>

#include "waymark/base/error.hpp"
#include "waymark/interface/map_module.hpp"

namespace waymark::fusion {

bool is_fused_after_start(const SensorSlot& slot) {
  return slot.fuse.mode != FuseRule::Mode::start && slot.fuse.mode != FuseRule::Mode::none;
}

namespace {

/// True if an absolute sensor can find the start (`fused` false), or is fused after it (`fused` true).
bool has_absolute(const std::vector<SensorSlot>& sensors, bool fused) {
  return std::any_of(sensors.begin(), sensors.end(), [&](const SensorSlot& s) {
    return s.enabled && s.sensor && s.sensor->traits().is_absolute && s.fuse.mode != FuseRule::Mode::none &&
           (!fused || is_fused_after_start(s));
  });
}

bool any_prior_map(const std::vector<MapSlot>& maps) {
  return std::ranges::any_of(maps, [](const MapSlot& map) { return map.module && map.module->has_prior_map(); });
}

/// A georeference needs maps, which it moves against the Earth, and an absolute sensor, which moves them. A prior map
/// lies where its file places it.
bool needs_georeference(const FusionSettings& settings, const std::vector<SensorSlot>& sensors,
                        const std::vector<MapSlot>& maps) {
  return settings.georeference.enabled && !maps.empty() && !any_prior_map(maps) && has_absolute(sensors, true);
}

bool triggers(const MapSlot& map, std::size_t sensor) { return map.inputs.front() == static_cast<int>(sensor); }

}  // namespace

/// Past beliefs are needed with maps only; without maps the host rolls back.
/// Loops are closed where nothing else bounds the drift: an absolute sensor is not in their graph. Nor is a robot
/// searched for in a map against what an absolute sensor says.
ParticleFilterSettings filter_settings(const FusionSettings& settings, const std::vector<SensorSlot>& sensors,
                                       const std::vector<MapSlot>& maps) {
  ParticleFilterSettings filter = settings.filter;
  filter.loops.enabled = settings.filter.loops.enabled && !has_absolute(sensors, true);
  filter.relocation.enabled = settings.filter.relocation.enabled && !has_absolute(sensors, true);
  filter.maps_begin_anywhere =
      !any_prior_map(maps) && (!has_absolute(sensors, true) || needs_georeference(settings, sensors, maps));
  filter.history = maps.empty() ? Duration::zero() : settings.history;
  return filter;
}

std::vector<std::shared_ptr<MapModule>> modules_of(const std::vector<MapSlot>& maps) {
  std::vector<std::shared_ptr<MapModule>> modules;
  modules.reserve(maps.size());
  for (const MapSlot& map : maps) modules.push_back(map.module);
  return modules;
}

std::vector<monitoring::HealthMonitor::Role> roles_of(const std::vector<SensorRecord>& sensors,
                                                      const std::vector<MapSlot>& maps) {
  std::vector<monitoring::HealthMonitor::Role> roles;
  roles.reserve(sensors.size());
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    const SensorSlot& slot = sensors[i].slot;
    const bool fused = slot.enabled && is_fused_after_start(slot);
    const bool localizes =
        std::ranges::any_of(maps, [&](const MapSlot& map) { return map.localize && triggers(map, i); });
    const bool has_prior_map = std::ranges::any_of(maps, [&](const MapSlot& map) {
      return map.localize && triggers(map, i) && map.module && map.module->has_prior_map();
    });
    const bool companion = std::ranges::any_of(
        maps, [&](const MapSlot& map) { return std::ranges::count(map.inputs, static_cast<int>(i)) > 0; });
    roles.push_back({.name = slot.name,
                     .is_motion_source = sensors[i].traits.is_motion_source,
                     .is_aiding = localizes || sensors[i].traits.is_absolute,
                     .localizes = localizes,
                     .has_prior_map = has_prior_map,
                     .fused = fused && (slot.sensor != nullptr || companion)});
  }
  return roles;
}

std::vector<SensorRecord> make_records(const std::vector<SensorSlot>& sensors, const std::vector<MapSlot>& maps) {
  std::vector<SensorRecord> records;
  records.reserve(sensors.size());
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    const SensorSlot& slot = sensors[i];
    const SensorTraits traits = slot.sensor ? slot.sensor->traits() : SensorTraits{};
    const particles::UpdatePolicy policy{static_cast<int>(i), particles::Gates(slot.gate_probability),
                                         slot.weight_exponent, false, traits.is_absolute};
    const bool triggering = std::ranges::any_of(maps, [&](const MapSlot& map) { return triggers(map, i); });
    SensorState state{slot.sensor, FuseGate(slot.fuse)};
    records.push_back({slot, policy, triggering, traits, std::move(state)});
  }
  return records;
}

StartSources start_sources(const std::vector<SensorSlot>& sensors, const std::vector<MapSlot>& maps) {
  return {has_absolute(sensors, false), has_absolute(sensors, true), any_prior_map(maps)};
}

std::vector<StateLayout::Owner> block_owners(const FusionSettings& settings, const std::vector<SensorSlot>& sensors,
                                             const std::vector<MapSlot>& maps) {
  std::vector<StateLayout::Owner> owners;
  owners.reserve(sensors.size() + 1);
  for (const SensorSlot& slot : sensors) {
    owners.push_back({slot.name, slot.sensor && slot.enabled ? slot.sensor->block() : StateBlock{}});
  }
  if (needs_georeference(settings, sensors, maps)) {
    owners.push_back({std::string(estimation::Georeference::kOwner),
                      estimation::Georeference::block(settings.motion, settings.georeference)});
  }
  return owners;
}

std::optional<estimation::Georeference> georeference_of(const StateLayout& layout, std::size_t sensors) {
  if (layout.owners().size() == sensors) return std::nullopt;
  return estimation::Georeference(layout, static_cast<int>(layout.owners().size()) - 1);
}

namespace {

/// Only one sensor may use an instrument: its errors would count twice.
void check_instruments(const std::vector<SensorSlot>& sensors) {
  std::map<std::string_view, const SensorSlot*> users;
  for (const SensorSlot& slot : sensors) {
    if (!slot.enabled || !slot.sensor || !is_fused_after_start(slot)) continue;
    const SensorTraits::Instrument instrument = slot.sensor->traits().instrument;
    if (instrument.name.empty()) continue;
    const auto [first, is_new] = users.try_emplace(instrument.name, &slot);
    if (is_new) continue;
    throw ConfigError(fmt::format(
        "sensors.{} and sensors.{} both take their heading from {}: if it is the same one, use it in one of them only; "
        "if not, {}",
        first->second->name, slot.name, instrument.name, instrument.unless));
  }
}

}  // namespace

namespace {

bool are_equal(const Datum& a, const Datum& b) {
  constexpr double kSamePlace = 1e-9;  // deg, a tenth of a millimetre
  constexpr double kSameHeight = 1e-3;
  return std::abs(a.latitude_deg - b.latitude_deg) <= kSamePlace &&
         std::abs(a.longitude_deg - b.longitude_deg) <= kSamePlace && std::abs(a.height_m - b.height_m) <= kSameHeight;
}

std::string text_of(const Datum& datum) {
  return fmt::format("{}, {}, {} m", datum.latitude_deg, datum.longitude_deg, datum.height_m);
}

std::string text_of(const MapFrame& frame) {
  return fmt::format("{} ({})", frame.manifest, frame.datum ? "datum " + text_of(*frame.datum) : "without a datum");
}

/// Loaded maps lie in one frame, or matches against them contradict each other. Throws ConfigError.
void check_prior_maps(const FusionSettings& settings, const std::vector<MapSlot>& maps) {
  const MapSlot* first = nullptr;
  std::optional<MapFrame> frame_of_first;
  for (const MapSlot& map : maps) {
    const std::optional<MapFrame> frame = map.module ? map.module->prior_frame() : std::nullopt;
    if (!frame) continue;
    if (settings.datum && frame->datum && !are_equal(*settings.datum, *frame->datum)) {
      throw ConfigError(fmt::format(
          "datum: {} is not that of the map \"{}\", {}; leave datum out, or move the map by waymark map georeference",
          text_of(*settings.datum), map.name, text_of(*frame)));
    }
    if (!first) {
      first = &map;
      frame_of_first = frame;
      continue;
    }
    const bool is_same = frame->datum && frame_of_first->datum ? are_equal(*frame->datum, *frame_of_first->datum)
                                                               : frame->manifest == frame_of_first->manifest;
    if (!is_same) {
      throw ConfigError(
          fmt::format("maps: \"{}\" and \"{}\" lie in different frames, {} and {}; load both from one "
                      "manifest",
                      first->name, map.name, text_of(*frame_of_first), text_of(*frame)));
    }
  }
}

}  // namespace

void check_parts(const FusionSettings& settings, const std::vector<SensorSlot>& sensors,
                 const std::vector<MapSlot>& maps) {
  const auto any = [&](auto property) {
    return std::any_of(sensors.begin(), sensors.end(), [&](const SensorSlot& s) {
      return s.enabled && s.sensor && is_fused_after_start(s) && property(*s.sensor);
    });
  };
  const bool has_motion_sensor = any([](const Sensor& s) { return s.traits().is_motion_source; });
  const bool has_localizing_map = std::ranges::any_of(maps, [&](const MapSlot& m) {
    const SensorSlot& trigger = sensors[static_cast<std::size_t>(m.inputs.front())];
    return m.localize && trigger.enabled && is_fused_after_start(trigger);
  });
  if (settings.motion_from_maps && has_motion_sensor) {
    throw ConfigError("motion.source: maps is for a robot without a motion sensor, but one is enabled");
  }
  if (settings.motion_from_maps && !has_localizing_map) {
    throw ConfigError("motion.source: maps needs a map that localises; there is none with an enabled sensor");
  }
  if (!settings.motion_from_maps && !has_motion_sensor) {
    throw ConfigError(
        "sensors: none of the enabled sensors measures the motion; add one (plugin: odometry, for example), or "
        "with a map that localises set motion.source: maps");
  }
  const auto spatial_map =
      std::ranges::find_if(maps, [](const MapSlot& m) { return m.localize && m.module && m.module->is_spatial(); });
  const bool is_spatial = settings.motion == StateLayout::Motion::spatial;
  if (!is_spatial && spatial_map != maps.end()) {
    throw ConfigError(
        fmt::format("motion.kind: planar holds height, roll and pitch, which the map \"{}\" matches; set it to spatial",
                    spatial_map->name));
  }
  if (is_spatial && spatial_map == maps.end() &&
      !any([](const Sensor& s) { return s.traits().observes_roll_and_pitch; })) {
    throw ConfigError(
        "motion.kind: spatial needs a sensor that observes roll and pitch, or a map that matches them (octomap_grid: "
        "match.kind: spatial); without one use planar");
  }
  check_instruments(sensors);
  check_prior_maps(settings, maps);
}

std::optional<Datum> datum_of(const FusionSettings& settings, const std::vector<MapSlot>& maps) {
  if (settings.datum) return settings.datum;
  for (const MapSlot& map : maps) {
    const std::optional<MapFrame> frame = map.module ? map.module->prior_frame() : std::nullopt;
    if (frame && frame->datum) return frame->datum;
  }
  return std::nullopt;
}

}  // namespace waymark::fusion
