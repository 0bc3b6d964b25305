// SPDX-License-Identifier: Apache-2.0
// Measurements that precede the committed one in the total order (docs/math/time.md).
#include <fmt/format.h>

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
    ++committed.record(m).state.counters.processed_late;
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
