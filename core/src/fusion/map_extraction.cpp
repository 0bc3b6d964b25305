// SPDX-License-Identifier: Apache-2.0
#include "fusion/map_extraction.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "fusion/setup.hpp"
#include "waymark/base/error.hpp"
#include "waymark/interface/map_module.hpp"

namespace waymark::fusion {

bool MapExtraction::localizes() const { return std::ranges::any_of(maps_, &MapSlot::localize); }

bool MapExtraction::has_companion(std::uint32_t sensor) const {
  return std::ranges::any_of(maps_, [&](const MapSlot& map) {
    return map.module &&
           std::find(map.inputs.begin() + 1, map.inputs.end(), static_cast<int>(sensor)) != map.inputs.end();
  });
}

std::vector<Companion> MapExtraction::companions_of(const MapSlot& map, const Measurement& m,
                                                    const Committed& committed) const {
  std::vector<Companion> companions;
  for (std::size_t k = 1; k < map.inputs.size(); ++k) {
    const SensorRecord& sensor = committed.sensors[static_cast<std::size_t>(map.inputs[k])];
    const auto& newest = sensor.newest;
    const bool fresh = newest && newest->stamp <= m.stamp && m.stamp - newest->stamp <= map.pair_max_age;
    companions.push_back({sensor.slot.name, fresh ? &*newest : nullptr});
  }
  return companions;
}

bool MapExtraction::waits_for_level(std::size_t map, const Measurement& m, bool has_motion_sensor, double tilt_sigma,
                                    Committed& committed) {
  const MapModule& module = *maps_[map].module;
  const auto observes_tilt = [](const SensorRecord& sensor) {
    return sensor.traits.observes_roll_and_pitch && sensor.state.sensor && sensor.mode == SensorMode::fused &&
           sensor.slot.enabled && is_fused_after_start(sensor.slot);
  };
  // A loaded map shows the tilt by itself. Without a motion sensor only the map shows the motion.
  if (!module.is_spatial() || module.has_prior_map() || !has_motion_sensor ||
      std::ranges::none_of(committed.sensors, observes_tilt)) {
    level_[map].end();
  }
  const LevelWait::State state = level_[map].at(m.stamp, tilt_sigma);
  if (state == LevelWait::State::begins_askew) {
    committed.note(
        m.stamp, fmt::format("map {}: begun with roll and pitch known to {:.1f}° only, after no sensor has "
                             "found them within {:.0f} s: it may lie askew by so much",
                             maps_[map].name, tilt_sigma * 180.0 / std::numbers::pi, to_seconds(LevelWait::kPatience)));
  }
  return state == LevelWait::State::waits;
}

Extraction MapExtraction::extract(const Measurement& m, const MotionWindow& motion, bool has_motion_sensor,
                                  double tilt_sigma, Committed& committed) {
  Extraction result;
  for (std::size_t i = 0; i < maps_.size(); ++i) {
    const MapSlot& map = maps_[i];
    if (!map.module || map.inputs.front() != static_cast<int>(m.sensor)) continue;
    if (!enabled_[i]) {
      result.held_out = true;
      continue;
    }
    if (waits_for_level(i, m, has_motion_sensor, tilt_sigma, committed)) {
      result.skipped = true;
      continue;
    }
    try {
      if (auto observation = map.module->extract(m, companions_of(map, m, committed), motion)) {
        const Observation* const content = observation.get();
        result.inputs.push_back({static_cast<int>(i), content, map.share, map.localize, std::move(observation)});
      } else {
        result.skipped = true;
      }
    } catch (const DataError& error) {
      if (unusable_[i]++ == 0)
        committed.note(m.stamp, fmt::format("{}: {} (further ones are only counted)", map.name, error.what()));
      result.unusable = true;
    } catch (const std::exception& error) {
      take_out_of_service(i, m.stamp, error.what(), committed);
    } catch (...) {
      take_out_of_service(i, m.stamp, "unknown exception", committed);
    }
  }
  return result;
}

void MapExtraction::enable(std::size_t map, bool enabled) {
  if (!maps_.at(map).module) throw Error(fmt::format("map \"{}\" is out of service", maps_[map].name));
  enabled_[map] = enabled;
}

void MapExtraction::take_out_of_service(std::size_t map, Time stamp, std::string_view why, Committed& committed) {
  committed.note_failure(stamp, "map " + maps_[map].name, why);
  committed.filter.drop_module(static_cast<int>(map));
  maps_[map].module = nullptr;
}

void MapExtraction::report(Time stamp, std::vector<Event>& events) const {
  for (std::size_t i = 0; i < maps_.size(); ++i) {
    if (unusable_[i] < 2) continue;  // there is an event of the first
    events.push_back({fmt::format("{}: {} measurements were unusable", maps_[i].name, unusable_[i]), stamp});
  }
}

namespace {

void serialize_module(OutArchive& out, const MapModule& module) { module.save(out); }
void serialize_module(InArchive& in, MapModule& module) { module.load(in); }

}  // namespace

template <class Archive>
void MapExtraction::serialize(Archive& archive, particles::ParticleFilter& filter) {
  std::uint64_t count = maps_.size();
  archive(count);
  if (count != maps_.size())
    throw DataError(fmt::format("the checkpoint has {} maps, the configuration {}", count, maps_.size()));
  for (std::size_t i = 0; i < maps_.size(); ++i) {
    MapSlot& map = maps_[i];
    std::string name = map.name;
    archive(name);
    if (name != map.name)
      throw DataError(fmt::format("the checkpoint was made with a map \"{}\" where now \"{}\" stands", name, map.name));
    bool in_service = map.module != nullptr;
    bool enabled = enabled_[i];
    archive(unusable_[i], in_service, enabled, level_[i]);
    enabled_[i] = enabled;
    if (in_service) {
      serialize_module(archive, *map.module);
    } else if (map.module) {
      map.module = nullptr;
      filter.drop_module(static_cast<int>(i));
    }
  }
}
template void MapExtraction::serialize(OutArchive& archive, particles::ParticleFilter& filter);
template void MapExtraction::serialize(InArchive& archive, particles::ParticleFilter& filter);

}  // namespace waymark::fusion
