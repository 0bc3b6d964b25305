// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "estimation/ekf.hpp"
#include "fusion/horizons.hpp"
#include "fusion/parts.hpp"

namespace waymark::fusion {

namespace ekf = estimation::ekf;

FrontHorizon::FrontHorizon(const Committed& committed, const estimation::ProcessModel& process,
                           const std::optional<Datum>& datum)
    : process_(process),
      datum_(datum),
      belief_(committed.filter.reported()),
      standing_(committed.standstill.standing()) {
  sensors_.reserve(committed.sensors.size());
  for (const SensorRecord& record : committed.sensors) {
    const Sensor* original = record.state.sensor.get();
    sensors_.push_back({original != nullptr ? original->clone() : nullptr, record.state.fuse, record.policy,
                        record.slot.delay, record.mode == SensorMode::fused});
  }
}

void FrontHorizon::predict(Time to) {
  if (to > belief_.stamp) process_.predict(belief_, to, standing_);
}

Belief FrontHorizon::predicted(Time to) const {
  Belief belief = belief_;
  if (to > belief.stamp) process_.predict(belief, to, standing_);
  return belief;
}

bool FrontHorizon::fuses(const Measurement& m) {
  Own& own = sensors_[m.sensor];
  return own.fuse.fuses(m.stamp) && own.steers;
}

bool FrontHorizon::follow_motion(const Measurement&, const UpdateList& updates) {
  if (const auto& unknown = updates.twist_reset(); unknown && !standing())
    ekf::release(belief_, process_.layout(), unknown->velocity_sigma, unknown->rate_sigma);
  return false;
}

/// The mixture's pose is in ENU, so no update needs the georeference.
void FrontHorizon::update(const Measurement& m, std::size_t, const Update& update, UpdateResult&) {
  const StateLayout& layout = process_.layout();
  const particles::UpdatePolicy& policy = sensors_[m.sensor].policy;
  const int block_offset = layout.block_offset(policy.owner);
  Linearization model;
  estimation::StateJacobian H;
  ekf::Innovation innovation;
  update.linearize({belief_.mean, belief_.mean.block.data() + block_offset}, model);
  H.reset(model.rows(), layout.size());
  estimation::scatter(layout, block_offset, model, H);
  ekf::innovate(belief_, model, H, innovation);
  if (innovation.finite && innovation.density.squared_mahalanobis <= policy.gates[model.rows()])
    ekf::apply(belief_, layout, innovation);
}

}  // namespace waymark::fusion
