// SPDX-License-Identifier: Apache-2.0
#include "estimation/ekf.hpp"
#include "fusion/horizons.hpp"

namespace waymark::fusion {

namespace ekf = estimation::ekf;

FrontHorizon::FrontHorizon(const Committed& committed, const estimation::ProcessModel& process,
                           const std::optional<Datum>& datum)
    : committed_(committed),
      process_(process),
      datum_(datum),
      belief_(committed.filter.mixture()),
      sensors_(committed.sensors.size()) {
  gates_.reserve(committed.sensors.size());
  for (const SensorRecord& sensor : committed.sensors) gates_.push_back(sensor.state.fuse);
}

void FrontHorizon::predict(Time to) {
  if (to > belief_.stamp) process_.predict(belief_, to, standing());
}

bool FrontHorizon::fuses(const Measurement& m) { return gates_[m.sensor].fuses(m.stamp); }

Sensor* FrontHorizon::sensor(const Measurement& m) {
  std::unique_ptr<Sensor>& own = sensors_[m.sensor];
  const Sensor* original = committed_.record(m).state.sensor.get();
  if (!own && original != nullptr) own = original->clone();
  return own.get();
}

bool FrontHorizon::follow_motion(const Measurement&, const UpdateList& updates) {
  if (const auto& unknown = updates.twist_reset(); unknown && !standing())
    ekf::release(belief_, process_.layout(), unknown->velocity_sigma, unknown->rate_sigma);
  return false;
}

/// The mixture's pose is in ENU, so no update needs the georeference.
void FrontHorizon::update(const Measurement& m, std::size_t, const Update& update, UpdateResult&) {
  const StateLayout& layout = process_.layout();
  const particles::UpdatePolicy& policy = committed_.record(m).policy;
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
