// SPDX-License-Identifier: Apache-2.0
#include "waymark/host/front.hpp"

#include <utility>

#include "fusion/parts.hpp"

namespace waymark {

struct Front::Impl {
  Impl(fusion::FrontHorizon at, const StateLayout& states) : horizon(std::move(at)), layout(states) {}

  fusion::FrontHorizon horizon;
  const StateLayout& layout;
  UpdateList updates;  // scratch
};

Front::Front(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Front::~Front() = default;

void Front::add(const Measurement& measurement) {
  Measurement m = measurement;
  m.stamp = corrected_stamp(m);
  if (m.stamp < stamp()) return;
  impl_->horizon.predict(m.stamp);
  process(m, impl_->horizon, impl_->layout, impl_->updates);
}

Time Front::corrected_stamp(const Measurement& m) const {
  return moved(m.stamp, -impl_->horizon.delay(m)).value_or(Time::min());
}

Time Front::stamp() const { return impl_->horizon.stamp(); }

Belief Front::at(Time at) const { return impl_->horizon.predicted(at); }

std::unique_ptr<Front> Fusion::front() const {
  const Parts& p = *parts_;
  if (!p.has_pose()) return nullptr;
  auto impl = std::make_unique<Front::Impl>(fusion::FrontHorizon(p.committed, p.process_model, p.datum), p.layout);
  return std::unique_ptr<Front>(new Front(std::move(impl)));
}

void Fusion::set_mode(std::uint32_t sensor, SensorMode mode) {
  fusion::SensorRecord& record = parts_->committed.sensors.at(sensor);
  record.mode = mode;
  record.policy.evaluate_only = mode == SensorMode::shadow;
}

SensorMode Fusion::mode(std::uint32_t sensor) const { return parts_->committed.sensors.at(sensor).mode; }

void Fusion::set_map_enabled(std::size_t map, bool enabled) { parts_->maps.enable(map, enabled); }

bool Fusion::map_enabled(std::size_t map) const { return parts_->maps.is_enabled(map); }

void Fusion::note_dropped(std::uint32_t sensor) {
  Parts& p = *parts_;
  if (p.has_pose()) p.committed.health.dropped(sensor, p.committed.filter.stamp());
}

void Fusion::note_missing(std::uint32_t sensor) {
  Parts& p = *parts_;
  if (p.has_pose()) p.committed.health.missing(sensor, p.committed.filter.stamp());
}

}  // namespace waymark
