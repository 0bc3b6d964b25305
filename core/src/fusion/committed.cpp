// SPDX-License-Identifier: Apache-2.0
#include "fusion/committed.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace waymark::fusion {

double tilt_sigma(const Belief& belief, const StateLayout& layout) {
  if (layout.motion() == StateLayout::Motion::planar) return 0.0;
  const SpatialMatrix P = spatial_covariance(belief);
  return std::sqrt(std::max({P(3, 3), P(4, 4), 0.0}));
}

void Committed::note(Time stamp, std::string text) { events.push_back({std::move(text), stamp}); }

void Committed::note_failure(Time stamp, std::string_view name, std::string_view why) {
  note(stamp, fmt::format("{}: taken out of service: {}", name, why));
  events.back().is_failure = true;
}

void Committed::take_out_of_service(const Measurement& m, std::string_view why) {
  SensorRecord& sensor = record(m);
  note_failure(m.stamp, sensor.slot.name, why);
  sensor.state.sensor = nullptr;
  health.out_of_service(m.sensor);
}

void Committed::count(const Measurement& m, Fate fate) {
  SensorCounters& counters = record(m).state.counters;
  switch (fate) {
    case Fate::fused:
      ++counters.fused;
      break;
    case Fate::gated:
      ++counters.gated;
      break;
    case Fate::mapped:
    case Fate::paired:
      ++counters.mapped;
      break;
    case Fate::skipped:
      ++counters.skipped;
      break;
    case Fate::held_out:
      ++counters.held_out;
      break;
    case Fate::late:
      ++counters.late;
      break;
    case Fate::before_start:
      ++counters.before_start;
      break;
    case Fate::unusable:
      ++counters.unusable;
      break;
    case Fate::ignored:
      ++counters.ignored;
      break;
    case Fate::mistimed:  // the clock monitor counts these
      break;
  }
}

std::size_t Committed::count_modes() {
  if (filter.set().size() == 1) return 1;
  // Most particles are too near to one another, as their mixture shows, which is known already.
  const Eigen::Matrix3d P = pose_covariance(std::as_const(filter).mixture(), filter.layout());
  if (!ModeFinder::may_have_modes(P)) return 1;
  filter.view(views);
  return modes.find(views).size();
}

void Committed::update_health(Time now) {
  health.place(filter.placement());
  health.set_particles_alone(filter.gave_up_joint());
  const Belief& belief = filter.reported();
  health.set_modes(count_modes());
  const auto& pose = filter.layout().pose_indices();
  const Eigen::Matrix2d P{{belief.P(pose[0], pose[0]), belief.P(pose[0], pose[1])},
                          {belief.P(pose[1], pose[0]), belief.P(pose[1], pose[1])}};
  const double mean = 0.5 * P.trace();
  const double largest = mean + std::sqrt(std::max(mean * mean - P.determinant(), 0.0));
  monitoring::HealthMonitor::Uncertainty sigma{std::sqrt(std::max(largest, 0.0))};
  if (filter.layout().motion() == StateLayout::Motion::spatial)
    sigma.height = std::sqrt(std::max(spatial_covariance(belief)(2, 2), 0.0));
  sigma.tilt = tilt_sigma(belief, filter.layout());
  health.judge(now, sigma);
}

void Committed::note_closed_loop(Time stamp) {
  const auto loop = filter.take_closed_loop();
  if (!loop) return;
  note(stamp,
       fmt::format("a loop of {:.0f} m was closed; the maps were drawn again, with places moved by up to {:.2f} m",
                   loop->way, loop->shift));
}

Mark Committed::mark(std::uint64_t at) const {
  Mark mark = mark_without_filter();
  mark.at = at;
  mark.filter = filter.state();
  return mark;
}

Mark Committed::mark_without_filter() const {
  Mark mark{0, filter.stamp(), {}, {}, standstill, health, events.size(), smoother.size(), last_stamp};
  mark.sensors.reserve(sensors.size());
  for (const SensorRecord& sensor : sensors) mark.sensors.push_back(sensor.state.clone());
  return mark;
}

void Committed::roll_back(const Mark& mark) {
  unsound = false;
  filter.restore(mark.filter);
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    // Counted on arrival, so it does not roll back.
    const std::uint64_t processed_late = sensors[i].state.counters.processed_late;
    sensors[i].state = mark.sensors[i].clone();
    sensors[i].state.counters.processed_late = processed_late;
  }
  standstill = mark.standstill;
  health = mark.health;
  new_events.roll_back(events, mark.events);
  events.resize(mark.events);
  smoother.truncate(mark.smoothed);
  last_stamp = mark.last_stamp;
}

void Committed::take(Mark&& mark) {
  for (std::size_t i = 0; i < sensors.size(); ++i) sensors[i].state = std::move(mark.sensors[i]);
  standstill = std::move(mark.standstill);
  health = std::move(mark.health);
  last_stamp = mark.last_stamp;
}

}  // namespace waymark::fusion
