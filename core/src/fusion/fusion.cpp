// SPDX-License-Identifier: Apache-2.0
#include "waymark/host/fusion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "fusion/fusion_impl.hpp"
#include "fusion/fusion_view.hpp"
#include "waymark/base/error.hpp"

namespace waymark {

void Fusion::Impl::event(Time stamp, std::string text) {
  events_.push_back({std::move(text), to_seconds(stamp.time_since_epoch())});
}

void Fusion::Impl::failure(Time stamp, std::string_view name, std::string_view why) {
  event(stamp, fmt::format("{}: taken out of service: {}", name, why));
  events_.back().is_failure = true;
}

/// The clock is looked at first; then the measurement waits for its turn, or is late.
void Fusion::Impl::add(Measurement m) {
  ++arrived_;
  SensorPart& part = parts_[m.sensor];
  m.stamp -= part.slot.delay;
  if (auto fault = clocks_.fault(m)) {
    if (skip_ > 0) {
      ++part.mistimed;
      return;
    }
    committed_.health.mistimed(m.sensor, started_ ? filter_.stamp() : m.arrival);
    if (part.mistimed++ == 0) {
      arrival_events_.push_back({fmt::format("{}: {} (further ones are only counted)", part.slot.name, *fault),
                                 to_seconds(m.arrival.time_since_epoch())});
    }
    show(m, Fate::mistimed);
    return;
  }
  if (!queue_.push(m)) {
    step(std::move(m), true);
    return;
  }
  while (auto due = queue_.pop_due()) step(std::move(*due), false);
}

void Fusion::Impl::step(Measurement&& m, bool is_late) {
  ++steps_;
  if (skip_ > 0) {
    --skip_;
    skipped_(m);
    return;
  }
  // Equal stamps are in order only within the window; without one the order of coming is good enough for maps.
  const bool at_once = is_late && !maps_.empty() && started_ && m.stamp == filter_.stamp();
  if (is_late && !at_once) {
    late(m);
  } else {
    commit(m);
  }
}

void Fusion::Impl::finish() {
  while (auto next = queue_.pop()) step(std::move(*next), false);
  if (started_) return;
  for (const Measurement& m : buffer_) count(m, Fate::before_start);
  buffer_.clear();
  event(committed_.last_stamp,
        "the filter never started: " + (arrived_ == 0                ? "no measurement has come"
                                        : !start_                    ? finder_.missing()
                                        : settings_.motion_from_maps ? "no map has been given a measurement"
                                                                     : "no motion sensor has said anything"));
}

void Fusion::Impl::commit(const Measurement& m) {
  if (!started_) {
    before_start(m);
    return;
  }
  const Fate fate = take_in(m);
  judge(m.stamp);
  show(m, fate);
}

void Fusion::Impl::before_start(const Measurement& m) {
  committed_.last_stamp = std::max(committed_.last_stamp, m.stamp);
  buffer_.insert(std::upper_bound(buffer_.begin(), buffer_.end(), m, MeasurementQueue::Order{}), m);
  if (!start_) start_ = finder_.consider(m, start_hint(m));
  if (!start_) return;
  // The clock starts with the first word about motion: until then the twist is anybody's guess, and a second of
  // guessing turns the map.
  const auto first_motion = std::find_if(buffer_.begin(), buffer_.end(), [&](const Measurement& b) {
    const SensorPart& part = parts_[b.sensor];
    const Sensor* sensor = committed_.sensors[b.sensor].sensor.get();
    const bool tells = settings_.motion_from_maps ? part.triggers_map : sensor != nullptr && sensor->is_motion_source();
    return b.stamp >= start_->prior.stamp && tells && goes_on_to_be_fused(part.slot);
  });
  if (first_motion == buffer_.end()) return;
  start_->prior.stamp = first_motion->stamp;
  begin(*start_);
}

std::optional<StartHint> Fusion::Impl::start_hint(const Measurement& m) {
  const Sensor* sensor = state_of(m).sensor.get();
  if (sensor == nullptr || parts_[m.sensor].slot.fuse.mode == FuseRule::Mode::none) return std::nullopt;
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
    out_of_service(m, error.what());
  } catch (...) {
    out_of_service(m, "unknown exception");
  }
  return std::nullopt;
}

void Fusion::Impl::begin(const Start& start) {
  filter_.start(start.prior, start.draw);
  started_ = true;
  committed_.health.start(start.prior.stamp);
  std::vector<Measurement> waiting;
  waiting.swap(buffer_);
  for (const Measurement& m : waiting) {
    const bool before = m.stamp < start.prior.stamp;
    if (before) state_of(m).fuse.fuses(m.stamp);  // its turns and stretches count from the first measurement
    if (start.used && m.sensor == start.used_sensor && m.sequence == start.used_sequence) {
      count(m, Fate::fused);  // it is in the start pose
      show(m, Fate::fused);
    } else if (before) {
      count(m, Fate::before_start);
      show(m, Fate::before_start);
    } else {
      commit(m);
    }
  }
}

/// One measurement on the committed side: predict, update, map, count.
Fate Fusion::Impl::take_in(const Measurement& m) {
  mark_if_due();
  if (history_.keeps()) history_.append(m);
  committed_.last_stamp = m.stamp;
  if (committed_.standstill.lapses(m.stamp)) {
    filter_.release(settings_.start.velocity_sigma, settings_.start.rate_sigma);
    if (settings_.smooth) smoother_.amend(filter_.mixture(), false);
  }
  filter_.predict(m.stamp, committed_.standstill.standing());

  const Fate fate = fuse(m, false);
  if (maps_.empty()) {
    filter_.record_path();
  } else {
    filter_.remember();
  }
  if (settings_.smooth) {
    const bool standing = committed_.standstill.standing();
    const bool updated = fate == Fate::fused || fate == Fate::gated;
    const bool forgot_twist = updated && !standing && updates_.forgotten_twist().has_value();
    smoother_.add(filter_.mixture(), standing, forgot_twist);
  }
  count(m, fate);
  return fate;
}

void Fusion::Impl::count(const Measurement& m, Fate fate) {
  SensorCounters& counters = state_of(m).counters;
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
    case Fate::unheard:
      ++counters.unheard;
      break;
    case Fate::mistimed:  // the clock monitor counts these
      break;
  }
}

void Fusion::Impl::judge(Time now) {
  const Belief& mixture = filter_.mixture();
  const auto& pose = layout_.pose_indices();
  const Eigen::Matrix2d P{{mixture.P(pose[0], pose[0]), mixture.P(pose[0], pose[1])},
                          {mixture.P(pose[1], pose[0]), mixture.P(pose[1], pose[1])}};
  const double mean = 0.5 * P.trace();
  const double largest = mean + std::sqrt(std::max(mean * mean - P.determinant(), 0.0));
  committed_.health.judge(now, std::sqrt(std::max(largest, 0.0)));
}

void Fusion::Impl::show(const Measurement& m, Fate fate) {
  last_ = {m, fate};
  if (observer_ && !redoing_) observer_(FusionView(filter_, maps_, health(), started_, m, fate));
}

void Fusion::Impl::show_last(const Observer& observer) const {
  if (last_) observer(FusionView(filter_, maps_, health(), started_, last_->first, last_->second));
}

RunReport Fusion::Impl::report() const {
  RunReport report;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    SensorReport& sensor = report.sensors.emplace_back();
    static_cast<SensorCounters&>(sensor) = committed_.sensors[i].counters;
    sensor.name = parts_[i].slot.name;
    sensor.plugin = parts_[i].slot.plugin;
    clocks_.report(i, sensor);
  }
  report.events = arrival_events_;
  for (std::size_t i = 0; i < maps_.size(); ++i) {
    if (unusable_to_[i] < 2) continue;  // an event has told of the first
    report.events.push_back({fmt::format("{}: {} measurements were of no use to it", maps_[i].name, unusable_to_[i]),
                             to_seconds(committed_.last_stamp.time_since_epoch())});
  }
  report.events.insert(report.events.end(), events_.begin(), events_.end());
  // That the filter never started is said last, whatever its time.
  std::stable_sort(report.events.begin(), report.events.end() - (started_ || report.events.empty() ? 0 : 1),
                   [](const Event& a, const Event& b) { return a.stamp_s < b.stamp_s; });
  report.resamplings = filter_.resamplings();
  report.mapping_steps = filter_.mapping_steps();
  report.smoothed = smoother_.smooth();
  return report;
}

Fusion::Fusion(const FusionSettings& settings, std::vector<SensorSlot> sensors, std::vector<MapSlot> maps,
               Observer observer)
    : impl_(std::make_unique<Impl>(settings, std::move(sensors), std::move(maps), std::move(observer))) {}
Fusion::~Fusion() = default;
void Fusion::add(Measurement measurement) { impl_->add(std::move(measurement)); }
void Fusion::finish() { impl_->finish(); }
bool Fusion::started() const { return impl_->started(); }
void Fusion::show_last(const Observer& observer) const { impl_->show_last(observer); }
Belief Fusion::front(Time at) const { return impl_->front(at); }
RunReport Fusion::report() const { return impl_->report(); }
void Fusion::save(OutArchive& out) const { impl_->save(out); }
void Fusion::resume(InArchive& in, const Next& next) { impl_->resume(in, next); }
const particles::ParticleFilter& Fusion::filter() const { return impl_->filter(); }
int Fusion::georeference_states() const {
  return filter().georeference() ? static_cast<int>(layout().owners().back().block.size()) : 0;
}
const StateLayout& Fusion::layout() const { return impl_->layout(); }
const Health& Fusion::health() const { return impl_->health(); }
std::optional<Datum> Fusion::datum() const { return impl_->datum(); }

}  // namespace waymark
