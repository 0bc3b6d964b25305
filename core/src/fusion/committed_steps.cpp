// SPDX-License-Identifier: Apache-2.0
#include "fusion/committed_steps.hpp"

#include <fmt/format.h>

#include "waymark/base/error.hpp"
#include "waymark/interface/map_module.hpp"

namespace waymark::fusion {

std::optional<StartHint> CommittedSteps::start_hint(const Measurement& m) {
  const SensorRecord& record = committed_.record(m);
  const Sensor* sensor = record.state.sensor.get();
  if (sensor == nullptr || record.slot.fuse.mode == FuseRule::Mode::none) return std::nullopt;
  try {
    auto hint = sensor->start_hint(m, datum_ ? &*datum_ : nullptr);
    if (hint && hint->datum && !datum_) {
      datum_ = hint->datum;
      hint = sensor->start_hint(m, &*datum_);
    }
    return hint;
  } catch (const DataError&) {
    return std::nullopt;
  } catch (const std::exception& error) {
    committed_.take_out_of_service(m, error.what());
  } catch (...) {
    committed_.take_out_of_service(m, "unknown exception");
  }
  return std::nullopt;
}

const Datum* CommittedSteps::datum(const Measurement& m) {
  if (!datum_) start_hint(m);  // a geodetic sensor may deliver only now
  return datum_ ? &*datum_ : nullptr;
}

bool CommittedSteps::account(const Measurement& m, std::size_t index, const particles::MixtureOutcome& outcome,
                             UpdateResult& result) {
  if (!outcome.usable) {
    result.fate = Fate::unusable;
    committed_.unsound = committed_.unsound || !committed_.filter.is_sound();
    if (!committed_.unsound) {
      note_unusable(m, "the innovation or its covariance is not finite, or the covariance not positive definite");
    }
    return false;
  }
  SensorState& state = committed_.record(m).state;
  const auto rows = static_cast<int>(outcome.innovation.size());
  if (!result.nis_is_trivial) {
    state.counters.nis_sum += outcome.nis;
    state.counters.nis_dof += static_cast<std::uint64_t>(rows);
    ++state.counters.nis_count;
    result.nis += outcome.nis;
    result.dof += rows;
  }
  state.sensor->outcome({index, outcome.innovation, outcome.S, outcome.nis, outcome.accepted});
  if (outcome.accepted) {
    state.rejections_in_a_row[index] = 0;
    state.measures_velocity = state.measures_velocity || outcome.observes_speed;
  } else if (result.fate == Fate::fused) {
    result.fate = Fate::gated;
  }
  return true;
}

/// An IMU alone measures how the robot turns: then, and while the wheels are silent, only the scans show how it moves.
bool CommittedSteps::velocity_is_measured() const {
  const std::vector<SensorHealth>& health = committed_.health.health().sensors;
  for (std::size_t i = 0; i < committed_.sensors.size(); ++i) {
    const SensorRecord& sensor = committed_.sensors[i];
    const bool delivers =
        health[i].state == SensorHealth::State::ok || health[i].state == SensorHealth::State::degraded;
    if (sensor.traits.is_motion_source && sensor.state.measures_velocity && delivers) return true;
  }
  return false;
}

/// A motion that only the scans show is compensated for by half. An error of it moves the next scan, which shows it
/// again: with all of it that diverges where beams are later than half of the time between scans
/// (docs/math/occupancy_grid.md).
MotionWindow CommittedSteps::window_of(const Belief& belief) const {
  constexpr double kOfScans = 0.5;
  MotionWindow window{belief.mean.v_base, belief.mean.w_base, belief.mean.T_map_base, velocity_is_measured()};
  if (!window.is_measured) window.v_base *= kOfScans;
  if (!has_motion_sensor_) window.w_base *= kOfScans;
  return window;
}

Extraction CommittedSteps::extract(const Measurement& m, const Belief& belief) {
  return maps_.extract(m, window_of(belief), has_motion_sensor_, tilt_sigma(belief, committed_.filter.layout()),
                       committed_);
}

void CommittedSteps::map(const Measurement& m, particles::Instant& at, const Extraction& extraction,
                         UpdateResult& result) {
  const bool was_misplaced = committed_.filter.is_misplaced();
  for (const auto& [input, why] : committed_.filter.map(at, extraction.inputs, m.sensor)) {
    const int module = extraction.inputs[static_cast<std::size_t>(input)].module;
    maps_.take_out_of_service(static_cast<std::size_t>(module), m.stamp, why, committed_);
  }
  if (const particles::MapInnovation& innovation = committed_.filter.map_innovation(); innovation.dof > 0) {
    SensorCounters& counters = committed_.record(m).state.counters;
    counters.nis_sum += innovation.nis;
    counters.nis_dof += static_cast<std::uint64_t>(innovation.dof);
    ++counters.nis_count;
  }
  if (const auto failure = committed_.filter.take_joint_failure(); failure.has_begun_anew) {
    committed_.note(m.stamp,
                    fmt::format("the joint Gaussian begins anew: {}, and is uncertain by that, too", failure.why));
  } else if (!failure.why.empty()) {
    committed_.note(m.stamp,
                    fmt::format("the joint Gaussian was given up: {}; from now on the covariance is that of the "
                                "particles alone, which is too small",
                                failure.why));
  }
  if (committed_.filter.take_loops_failure())
    committed_.note(m.stamp, "the path has become too long: loops are not searched for any more");
  committed_.note_closed_loop(m.stamp);
  note_misplaced(m, was_misplaced);
  if (committed_.filter.fails_to_recognise())
    result.degraded_reason = "known places are not recognised: the map may be torn";
  result.fate = Fate::mapped;
}

void CommittedSteps::note_misplaced(const Measurement& m, bool was_misplaced) {
  if (const std::string why = committed_.filter.take_relocation_failure(); !why.empty())
    committed_.note(m.stamp, fmt::format("a robot that is misplaced in the loaded map will not be found: {}", why));
  const bool is_misplaced = committed_.filter.is_misplaced();
  if (is_misplaced && !was_misplaced) {
    committed_.note(m.stamp,
                    fmt::format("{}: its scans do not fit the loaded map where the robot is believed to be; it is "
                                "searched for in the whole map",
                                committed_.record(m).slot.name));
  } else if (was_misplaced && !is_misplaced && committed_.filter.relocates() && !committed_.filter.has_place()) {
    committed_.note(m.stamp, fmt::format("{}: its scans fit the loaded map again", committed_.record(m).slot.name));
  }
}

void CommittedSteps::note_unusable(const Measurement& m, std::string_view why) {
  const SensorRecord& record = committed_.record(m);
  if (record.state.counters.unusable > 0) return;
  committed_.note(m.stamp, fmt::format("{}: {} (further ones are only counted)", record.slot.name, why));
}

void CommittedSteps::conclude(const Measurement& m, UpdateResult& result) {
  SensorRecord& record = committed_.record(m);
  if (result.fate != Fate::held_out) {
    if (!maps_.empty() && (!record.newest || record.newest->stamp <= m.stamp)) record.newest = m;
    if (result.fate == Fate::ignored && maps_.has_companion(m.sensor)) result.fate = Fate::paired;
  }
  committed_.health.record(m.sensor, m.stamp, result);
  SensorState& state = record.state;
  if (result.fate == Fate::ignored && !state.ignored_noted) {
    state.ignored_noted = true;
    committed_.note(m.stamp,
                    fmt::format("{}: no plugin in service takes its measurements, they are ignored", record.slot.name));
  }
  if (!state.not_localized_noted && committed_.health.is_not_localized(m.sensor)) {
    state.not_localized_noted = true;
    committed_.note(m.stamp,
                    fmt::format("{}: most of its scans do not localise the robot in the loaded map: it "
                                "started elsewhere, or this is another place (reported once; health follows it)",
                                record.slot.name));
  }
}

}  // namespace waymark::fusion
