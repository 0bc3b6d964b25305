// SPDX-License-Identifier: Apache-2.0
// Measurements that precede the committed one in the total order (docs/math/time.md).
#include <fmt/format.h>

#include <cmath>
#include <cstdint>

#include "fusion/parts.hpp"

namespace waymark {

void Fusion::Parts::process_late(const Measurement& m) {
  Fate fate = Fate::late;
  if (maps.empty() && history.reaches(m.stamp)) {
    fate = roll_back_and_repeat(m);
    ++committed.record(m).state.counters.processed_late;
  } else if (particles::Instant* past_particles = maps.empty() ? nullptr : committed.filter.recall(m.stamp)) {
    fusion::PastHorizon past(steps, *past_particles);
    fate = process(m, past, layout, updates);
    committed.count(m, fate);
    constexpr std::uint64_t kOften = 10;
    if (++committed.record(m).state.counters.processed_late == kOften) note_often_late(m);
  } else {
    committed.count(m, fate);
    note_too_late(m);
  }
  committed.update_health(committed.filter.stamp());
  notify_observer(m, fate);
}

/// Without maps: rolls back to the mark before the measurement and processes all from there in order. The result is
/// byte-identical to that of a log in order.
Fate Fusion::Parts::roll_back_and_repeat(const Measurement& m) {
  std::vector<Measurement> again;
  committed.roll_back(history.rewind(m, again));
  Fate fate = Fate::late;
  for (const Measurement& repeated : again) {
    if (!has_pose()) {
      await_start(repeated);
      continue;
    }
    const Fate one = predict_and_process(repeated);
    if (committed.unsound) lose_pose(repeated.stamp, kUnsound);
    if (repeated.sensor == m.sensor && repeated.sequence == m.sequence) fate = one;
  }
  return fate;
}

void Fusion::Parts::mark_if_due() {
  if (history.keeps() && history.needs_mark()) history.mark(committed.mark(history.count()));
}

/// With maps: what is late weights the particles only, so scans correct no pose and wheels move none.
void Fusion::Parts::note_often_late(const Measurement& m) {
  const fusion::SensorRecord& sensor = committed.record(m);
  if (!sensor.triggers_map && !sensor.traits.is_motion_source) return;
  const double latency_s = to_seconds(m.arrival - m.stamp);
  arrival_events.push_back(
      {fmt::format("{}: measurements come {:.3f} s after their stamps, after others that were committed already; they "
                   "only weight the particles, {}; filter.max_latency_s: {:.1f} would wait for them",
                   sensor.slot.name, latency_s, sensor.triggers_map ? "and correct no pose" : "and move no particle",
                   std::ceil(12.0 * latency_s) / 10.0),
       m.arrival});
}

void Fusion::Parts::note_too_late(const Measurement& m) {
  fusion::SensorRecord& sensor = committed.record(m);
  if (sensor.too_late_noted) return;
  sensor.too_late_noted = true;
  const Duration behind = committed.filter.stamp() - m.stamp;
  arrival_events.push_back(
      {fmt::format("{}: a measurement came {:.3f} s after its stamp, {:.3f} s behind what was committed: too late for "
                   "filter.history_s (further ones are only counted)",
                   sensor.slot.name, to_seconds(m.arrival - m.stamp), to_seconds(behind)),
       m.arrival});
}

}  // namespace waymark
