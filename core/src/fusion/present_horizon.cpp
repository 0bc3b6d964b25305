// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "fusion/horizons.hpp"

namespace waymark::fusion {

bool PresentHorizon::follow_motion(const Measurement& m, const UpdateList& updates) {
  if (follow_standstill(m, updates)) return true;
  if (const auto& unknown = updates.forgotten_twist(); unknown && !standing()) {
    filter().release(unknown->velocity_sigma, unknown->rate_sigma);
  }
  return false;
}

/// What a sensor measures of its own states (a gyro's bias) is never better known than while the robot stands, so a
/// sensor with own states is updated all the same.
bool PresentHorizon::follow_standstill(const Measurement& m, const UpdateList& updates) {
  if (updates.motion() == UpdateList::Motion::not_said) return false;
  monitoring::Standstill& standstill = steps_.committed().standstill;
  const bool stood = standstill.standing();
  standstill.report(m.sensor, m.stamp, updates.motion() == UpdateList::Motion::moving,
                    updates.forgotten_twist().has_value());
  if (!stood && standstill.standing()) filter().stop();
  if (stood && !standstill.standing()) filter().release(settings_.start.velocity_sigma, settings_.start.rate_sigma);
  const auto owner = static_cast<std::size_t>(record(m).policy.owner);
  return standstill.standing() && record(m).traits.is_motion_source && filter().layout().owners()[owner].block.empty();
}

void PresentHorizon::update(const Measurement& m, std::size_t index, const Update& update, UpdateResult& result) {
  SensorRecord& record = this->record(m);
  const particles::MixtureOutcome outcome = filter().update(update, record.policy);
  if (!steps_.account(m, index, outcome, result)) return;
  if (outcome.accepted) {
    const bool is_position = update.observes() == Quantity::position && outcome.innovation.size() > 1;
    if (index == 0 && is_position) watch_for_bias(m, outcome, result);
  } else if (record.slot.max_consecutive_rejections > 0 &&
             ++record.state.rejections_in_a_row[index] >= record.slot.max_consecutive_rejections) {
    reacquire(m, index, update, outcome);
  }
}

/// Biased innovations of a position: the robot slips, or the fixes creep away. Which of the two cannot be decided
/// here; that the position is less certain than the filter believes is sure. Where maps localise, the robot is located
/// in them all the same: only the map's place on the Earth is widened, and without a georeference nothing, since fixes
/// that creep would tear the map.
void PresentHorizon::watch_for_bias(const Measurement& m, const particles::MixtureOutcome& outcome,
                                    UpdateResult& result) {
  SensorState& state = record(m).state;
  if (!state.bias.take(outcome.innovation, outcome.S)) return;
  const Eigen::Vector2d bias = state.bias.mean().head<2>();
  const bool widens = filter().georeference() || !steps_.maps().localizes();
  if (widens) filter().inflate_pose(bias.squaredNorm(), 0.0);
  if (settings_.smooth) steps_.committed().smoother.cut_next();
  result.doubt = "its innovations are biased: it, or the motion source, is wrong";
  if (state.biased++ == 0) {
    steps_.committed().note(
        m.stamp, fmt::format("{}: its innovations are biased by {:.3g} m; it, or the motion source, is wrong{} "
                             "(further times are only counted)",
                             record(m).slot.name, bias.norm(), widens ? ", and the position was widened" : ""));
  }
  state.bias.restart();
}

/// A sensor that was rejected too often in a row is right and the filter is wrong, or the other way round; a filter
/// that never follows it again is the worse of the two.
void PresentHorizon::reacquire(const Measurement& m, std::size_t index, const Update& update,
                               const particles::MixtureOutcome& outcome) {
  constexpr double kYawSigma = 0.17;  // 10°: enough for the next fixes to turn the heading
  SensorRecord& record = this->record(m);
  const double miss = outcome.innovation.norm();
  if (record.traits.is_absolute) {
    filter().inflate_pose(miss * miss, kYawSigma * kYawSigma);
  } else {
    filter().release(settings_.start.velocity_sigma, settings_.start.rate_sigma);
  }
  if (settings_.smooth) steps_.committed().smoother.cut_next();
  steps_.committed().health.reacquired(m.stamp);
  particles::UpdatePolicy open = record.policy;
  open.ignore_gate = true;
  filter().update(update, open);
  steps_.committed().note(
      m.stamp, fmt::format("{}: {} measurements in a row rejected, the last one by {:.3g}; the belief was widened and "
                           "the sensor re-acquired",
                           record.slot.name, record.state.rejections_in_a_row[index], miss));
  record.state.rejections_in_a_row[index] = 0;
}

void PresentHorizon::map(const Measurement& m, const Extraction& extraction, UpdateResult& result) {
  steps_.map(m, filter().now(), extraction, result);
  if (std::ranges::any_of(extraction.inputs, &particles::MappingInput::localize)) result.located = filter().located();
}

}  // namespace waymark::fusion
