// SPDX-License-Identifier: Apache-2.0
// What one measurement does to the filter: updates, maps, standstill, re-acquisition.
#include <fmt/format.h>

#include <algorithm>

#include "fusion/fusion_impl.hpp"
#include "waymark/base/error.hpp"

namespace waymark {

/// The measurement of now, or of the recalled time if `late`: into the EKFs, then into the maps.
Fate Fusion::Impl::fuse(const Measurement& m, bool late) {
  SensorState& state = state_of(m);
  monitoring::Heard heard;
  heard.fate = Fate::unheard;
  if (!state.fuse.fuses(m.stamp)) {
    heard.fate = Fate::held_out;
  } else {
    if (state.sensor) update(m, late, heard);
    if (parts_[m.sensor].triggers_map) map(m, late, heard);
    auto& newest = newest_[m.sensor];
    if (!maps_.empty() && (!newest || newest->stamp <= m.stamp)) newest = m;
    if (heard.fate == Fate::unheard && is_companion(m.sensor)) heard.fate = Fate::paired;
  }
  committed_.health.heard(m.sensor, m.stamp, heard);
  const std::string& name = parts_[m.sensor].slot.name;
  if (heard.fate == Fate::unheard && !state.told_unheard) {
    state.told_unheard = true;
    event(m.stamp, fmt::format("{}: no plugin in service listens to this sensor", name));
  }
  if (!state.told_elsewhere && committed_.health.is_elsewhere(m.sensor)) {
    state.told_elsewhere = true;
    event(m.stamp,
          fmt::format("{}: most of what it sees does not tell where in the loaded map the robot is: it started "
                      "elsewhere, or this is another place (told once; health follows it)",
                      name));
  }
  return heard.fate;
}

/// True if a map in service takes this sensor's measurements along with those of its first input.
bool Fusion::Impl::is_companion(std::uint32_t sensor) const {
  return std::ranges::any_of(maps_, [&](const MapSlot& map) {
    return map.module &&
           std::find(map.inputs.begin() + 1, map.inputs.end(), static_cast<int>(sensor)) != map.inputs.end();
  });
}

void Fusion::Impl::update(const Measurement& m, bool late, monitoring::Heard& heard) {
  if (!datum_) start_hint(m);  // a geodetic sensor that only now delivers settles the map's origin
  SensorState& state = state_of(m);
  if (!state.sensor) return;  // out of service by that
  const std::string& name = parts_[m.sensor].slot.name;
  const Belief& mixture = late ? filter_.recalled_mixture() : filter_.mixture();
  const int owner = parts_[m.sensor].policy.owner;
  const Prediction prediction{mixture, layout_, mixture.mean.block.data() + layout_.block_offset(owner),
                              datum_ ? &*datum_ : nullptr, committed_.standstill.standing()};
  updates_.clear();
  try {
    state.sensor->process(m, prediction, updates_);
    heard.doubt = updates_.doubt();
    heard.fate = Fate::fused;
    // What a sensor doubts so much that it gives no update of it is rejected, if not by the gate.
    if (updates_.size() == 0 && !heard.doubt.empty()) heard.fate = Fate::gated;
    if (!late && settle_motion(m)) return;
    if (const auto& unknown = updates_.forgotten_twist(); unknown && !late && !committed_.standstill.standing()) {
      filter_.release(unknown->velocity_sigma, unknown->rate_sigma);
    }
    for (std::size_t i = 0; i < updates_.size(); ++i) apply(m, i, late, heard);
  } catch (const DataError& error) {
    heard.doubt = updates_.doubt();
    if (state.counters.unusable == 0) {
      event(m.stamp, fmt::format("{}: {} (further ones are only counted)", name, error.what()));
    }
    heard.fate = Fate::unusable;
  } catch (const std::exception& error) {
    heard.fate = Fate::unheard;
    out_of_service(m, error.what());
  } catch (...) {
    heard.fate = Fate::unheard;
    out_of_service(m, "unknown exception");
  }
}

/// One of the measurement's updates: into every particle, and the outcome back to its sensor.
void Fusion::Impl::apply(const Measurement& m, std::size_t index, bool late, monitoring::Heard& heard) {
  SensorState& state = state_of(m);
  const SensorPart& part = parts_[m.sensor];
  if (late && index > 0) filter_.recall(m.stamp);  // the update before has taught something about that time, too
  const particles::MixtureOutcome outcome =
      late ? filter_.update_late(updates_[index], part.policy) : filter_.update(updates_[index], part.policy);
  if (!outcome.usable) {
    heard.fate = Fate::unusable;
    return;
  }
  const auto rows = static_cast<int>(outcome.innovation.size());
  state.counters.nis_sum += outcome.nis;
  state.counters.nis_dof += static_cast<std::uint64_t>(rows);
  ++state.counters.nis_count;
  heard.nis += outcome.nis;
  heard.dof += rows;
  state.sensor->outcome({index, outcome.innovation, outcome.S, outcome.nis, outcome.accepted});
  if (outcome.accepted) {
    state.rejections_in_a_row[index] = 0;
    if (!late && index == 0 && rows > 1 && state.sensor->is_absolute()) watch_for_bias(m, outcome, heard);
    return;
  }
  if (heard.fate == Fate::fused) heard.fate = Fate::gated;
  if (!late && part.slot.max_consecutive_rejections > 0 &&
      ++state.rejections_in_a_row[index] >= part.slot.max_consecutive_rejections) {
    reacquire(m, index, outcome);
  }
}

/// Fixes that all lie on one side of where they are expected: the robot slips, or they creep away. Which of the two
/// cannot be told here; that the position is worse known than the filter believes is sure. Where maps localise, the
/// place in them is known all the same: only the map's place on the Earth is widened, and without a georeference
/// nothing, since fixes that creep would tear the map.
void Fusion::Impl::watch_for_bias(const Measurement& m, const particles::MixtureOutcome& outcome,
                                  monitoring::Heard& heard) {
  SensorState& state = state_of(m);
  if (!state.bias.take(outcome.innovation, outcome.S)) return;
  const Eigen::Vector2d bias = state.bias.mean().head<2>();
  const bool widens = filter_.georeference() || std::ranges::none_of(maps_, &MapSlot::localize);
  if (widens) filter_.inflate_pose(bias.squaredNorm(), 0.0);
  if (settings_.smooth) smoother_.cut_next();
  heard.doubt = "its innovations point to one side: it, or what tells the motion, is wrong";
  if (state.biased++ == 0) {
    event(m.stamp,
          fmt::format("{}: its innovations point to one side by {:.3g} m; it, or what tells the motion, is "
                      "wrong{} (further times are only counted)",
                      parts_[m.sensor].slot.name, bias.norm(), widens ? ", and the position was widened" : ""));
  }
  state.bias.restart();
}

/// Follows what motion sensors say; true if the robot stands, and the zero twist has replaced the update. What a sensor
/// tells of its own states (a gyro's bias) is never better known than now.
bool Fusion::Impl::settle_motion(const Measurement& m) {
  if (updates_.motion() == UpdateList::Motion::not_said) return false;
  monitoring::Standstill& standstill = committed_.standstill;
  const bool stood = standstill.standing();
  standstill.report(m.sensor, m.stamp, updates_.motion() == UpdateList::Motion::moving,
                    updates_.forgotten_twist().has_value());
  if (!stood && standstill.standing()) filter_.stop();
  if (stood && !standstill.standing()) filter_.release(settings_.start.velocity_sigma, settings_.start.rate_sigma);
  const auto owner = static_cast<std::size_t>(parts_[m.sensor].policy.owner);
  return standstill.standing() && state_of(m).sensor->is_motion_source() && layout_.owners()[owner].block.empty();
}

/// A sensor that was rejected too often in a row is right and the filter is wrong, or the other way round; a filter
/// that never listens again is the worse of the two.
void Fusion::Impl::reacquire(const Measurement& m, std::size_t index, const particles::MixtureOutcome& outcome) {
  constexpr double kYawSigma = 0.17;  // 10°: enough for the next fixes to turn the heading
  SensorState& state = state_of(m);
  const SensorPart& part = parts_[m.sensor];
  const double miss = outcome.innovation.norm();
  if (state.sensor->is_absolute()) {
    filter_.inflate_pose(miss * miss, kYawSigma * kYawSigma);
  } else {
    filter_.release(settings_.start.velocity_sigma, settings_.start.rate_sigma);
  }
  if (settings_.smooth) smoother_.cut_next();
  committed_.health.reacquired(m.stamp);
  particles::UpdatePolicy open = part.policy;
  open.ignore_gate = true;
  filter_.update(updates_[index], open);
  event(m.stamp,
        fmt::format("{}: {} measurements in a row rejected, the last one by {:.3g}; the belief was widened and "
                    "the sensor re-acquired",
                    part.slot.name, state.rejections_in_a_row[index], miss));
  state.rejections_in_a_row[index] = 0;
}

void Fusion::Impl::map(const Measurement& m, bool late, monitoring::Heard& heard) {
  const Belief& mixture = late ? filter_.recalled_mixture() : filter_.mixture();
  const MotionWindow motion{mixture.mean.v_base, mixture.mean.w_base, mixture.mean.T_map_base};
  std::vector<particles::MappingInput> inputs;
  std::vector<std::shared_ptr<const Observation>> observations;  // keeps them alive
  std::vector<Companion> companions;
  bool was_skipped = false;
  for (std::size_t i = 0; i < maps_.size(); ++i) {
    MapSlot& map = maps_[i];
    if (!map.module || map.inputs.front() != static_cast<int>(m.sensor)) continue;
    companions.clear();
    for (std::size_t k = 1; k < map.inputs.size(); ++k) {
      const auto& newest = newest_[static_cast<std::size_t>(map.inputs[k])];
      const bool fresh = newest && newest->stamp <= m.stamp && m.stamp - newest->stamp <= map.pair_max_age;
      companions.push_back({parts_[static_cast<std::size_t>(map.inputs[k])].slot.name, fresh ? &*newest : nullptr});
    }
    try {
      if (auto observation = map.module->extract(m, companions, motion)) {
        inputs.push_back({static_cast<int>(i), observation.get(), map.share, map.localize});
        observations.push_back(std::move(observation));
      } else {
        was_skipped = true;
      }
    } catch (const DataError& error) {
      if (unusable_to_[i]++ == 0)
        event(m.stamp, fmt::format("{}: {} (further ones are only counted)", map.name, error.what()));
      heard.fate = Fate::unusable;
    } catch (const std::exception& error) {
      map_out_of_service(i, m.stamp, error.what());
    } catch (...) {
      map_out_of_service(i, m.stamp, "unknown exception");
    }
  }
  if (inputs.empty()) {
    if (!was_skipped) return;
    if (!late) filter_.record_tentative_path();
    if (heard.fate == Fate::unheard) heard.fate = Fate::skipped;
    return;
  }
  for (const auto& [input, why] : late ? filter_.map_late(inputs, m.sensor) : filter_.map(inputs, m.sensor))
    map_out_of_service(static_cast<std::size_t>(inputs[static_cast<std::size_t>(input)].module), m.stamp, why);
  heard.fate = Fate::mapped;
  if (!late && std::ranges::any_of(inputs, &particles::MappingInput::localize)) heard.located = filter_.located();
}

void Fusion::Impl::map_out_of_service(std::size_t map, Time stamp, std::string_view why) {
  failure(stamp, "map " + maps_[map].name, why);
  filter_.drop_module(static_cast<int>(map));
  maps_[map].module = nullptr;
}

void Fusion::Impl::out_of_service(const Measurement& m, std::string_view why) {
  failure(m.stamp, parts_[m.sensor].slot.name, why);
  state_of(m).sensor = nullptr;
  committed_.health.out_of_service(m.sensor);
}

}  // namespace waymark
