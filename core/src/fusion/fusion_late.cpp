// SPDX-License-Identifier: Apache-2.0
// Two horizons (estimation.md §2, "Order"): what comes late, and what is not committed yet.
#include <fmt/format.h>

#include <utility>

#include "estimation/ekf.hpp"
#include "fusion/fusion_impl.hpp"
#include "waymark/base/error.hpp"

namespace waymark {

/// A measurement that comes, in the total order, before what was committed already.
void Fusion::Impl::late(const Measurement& m) {
  if (!started_) {
    before_start(m);
    return;
  }
  SensorPart& part = parts_[m.sensor];
  Fate fate = Fate::late;
  if (maps_.empty() ? history_.reaches(m.stamp) : filter_.recall(m.stamp)) {
    fate = maps_.empty() ? rewind(m) : weigh(m);
    ++state_of(m).counters.taken_in_late;
  } else {
    count(m, fate);
    if (!part.told_late) {
      part.told_late = true;
      arrival_events_.push_back(
          {fmt::format(
               "{}: a measurement came {:.3f} s after its stamp, {:.3f} s behind what was committed: too late for "
               "filter.history_s (further ones are only counted)",
               part.slot.name, to_seconds(m.arrival - m.stamp), to_seconds(filter_.stamp() - m.stamp)),
           to_seconds(m.arrival.time_since_epoch())});
    }
  }
  judge(filter_.stamp());
  show(m, fate);
}

/// Without maps: back to the mark before it, then forward again with the measurement in its place.
Fate Fusion::Impl::rewind(const Measurement& m) {
  go_back(history_.rewind(m, again_));
  Fate fate = Fate::late;
  for (const Measurement& again : again_) {
    const Fate one = take_in(again);
    if (again.sensor == m.sensor && again.sequence == m.sequence) fate = one;
  }
  return fate;
}

/// With maps: sampled paths and maps stay; the measurement weighs the particles where each of them was then.
Fate Fusion::Impl::weigh(const Measurement& m) {
  const Fate fate = fuse(m, true);
  count(m, fate);
  return fate;
}

void Fusion::Impl::go_back(const Mark& mark) {
  filter_.restore(mark.filter);
  // How much came late is known by what comes, so it does not go back with the filter.
  std::vector<std::uint64_t> taken_in_late;
  for (const SensorState& state : committed_.sensors) taken_in_late.push_back(state.counters.taken_in_late);
  committed_ = mark.committed.clone();
  for (std::size_t i = 0; i < taken_in_late.size(); ++i) {
    committed_.sensors[i].counters.taken_in_late = taken_in_late[i];
  }
  events_.resize(committed_.events);
  smoother_.truncate(committed_.smoothed);
}

void Fusion::Impl::mark_if_due() {
  if (!history_.keeps() || !history_.wants_mark()) return;
  committed_.events = events_.size();
  committed_.smoothed = smoother_.size();
  history_.mark({history_.count(), filter_.stamp(), filter_.state(), committed_.clone()});
}

Belief Fusion::Impl::front(Time at) const {
  if (!started_) throw Error("the filter has not started");
  if (at < filter_.stamp()) {
    throw Error(fmt::format("a pose at {} was asked for, before what is committed ({})", format_time(at),
                            format_time(filter_.stamp())));
  }
  Belief belief = filter_.mixture();
  const bool standing = committed_.standstill.standing();
  std::vector<std::unique_ptr<Sensor>> own(parts_.size());  // what is not committed must not touch the sensors' state
  std::vector<FuseGate> gates;
  for (const SensorState& state : committed_.sensors) gates.push_back(state.fuse);
  Linearization model;
  estimation::ekf::Innovation innovation;
  UpdateList updates;
  for (const Measurement& m : queue_.waiting()) {
    if (m.stamp > at) break;
    const SensorPart& part = parts_[m.sensor];
    const Sensor* sensor = committed_.sensors[m.sensor].sensor.get();
    const bool fuses = gates[m.sensor].fuses(m.stamp);
    if (sensor == nullptr || !fuses || !goes_on_to_be_fused(part.slot)) continue;
    process_.predict(belief, m.stamp, standing);
    if (!own[m.sensor]) own[m.sensor] = sensor->clone();
    const int owner = part.policy.owner;
    const double* block = belief.mean.block.data() + layout_.block_offset(owner);
    updates.clear();
    try {
      own[m.sensor]->process(m, {belief, layout_, block, datum_ ? &*datum_ : nullptr, standing}, updates);
      if (const auto& unknown = updates.forgotten_twist(); unknown && !standing)
        estimation::ekf::release(belief, layout_, unknown->velocity_sigma, unknown->rate_sigma);
      for (std::size_t i = 0; i < updates.size(); ++i) {
        updates[i].linearize({belief.mean, block}, model);
        estimation::ekf::innovate(belief, layout_, owner, model, innovation);
        if (innovation.finite && innovation.density.squared_mahalanobis <= part.policy.gates[model.rows()])
          estimation::ekf::apply(belief, layout_, innovation);
      }
    } catch (const std::exception&) {
      // The committed side meets the same measurement soon and reports it.
    }
  }
  if (at > belief.stamp) process_.predict(belief, at, standing);
  return belief;
}

}  // namespace waymark
