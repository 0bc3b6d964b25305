// SPDX-License-Identifier: Apache-2.0
// Before the start: measurements are buffered until start pose and first motion measurement are known, then processed
// in order.
#include <algorithm>

#include "fusion/parts.hpp"

namespace waymark {

void Fusion::Parts::await_start(const Measurement& m) {
  committed.last_stamp = std::max(committed.last_stamp, m.stamp);
  const auto hint = startup.needs_pose() ? steps.start_hint(m) : std::nullopt;
  if (const auto start = startup.process(m, hint, committed.sensors)) begin(*start);
}

void Fusion::Parts::begin(const fusion::Start& start) {
  committed.filter.start(start.prior, start.draw);
  committed.filter.mixture();  // `front` may be called before the first commit
  started = true;
  committed.health.start(start.prior.stamp);
  for (const Measurement& m : startup.release()) {
    const bool before = m.stamp < start.prior.stamp;
    // Alternation and stretches count from its first measurement.
    if (before) committed.record(m).state.fuse.fuses(m.stamp);
    if (start.used && m.sensor == start.used_sensor && m.sequence == start.used_sequence) {
      committed.count(m, Fate::fused);  // used for the start pose
      notify_observer(m, Fate::fused);
    } else if (before) {
      committed.count(m, Fate::before_start);
      notify_observer(m, Fate::before_start);
    } else {
      commit(m);
    }
  }
}

void Fusion::finish() {
  Parts& p = *parts_;
  p.intake.finish([&](const Measurement& m, bool is_late) { p.dispatch(m, is_late); });
  if (p.started) return;
  for (const Measurement& m : p.startup.release()) p.committed.count(m, Fate::before_start);
  p.committed.note(p.committed.last_stamp, "the filter never started: " +
                                               (p.arrived == 0 ? "no measurement has arrived" : p.startup.missing()));
}

}  // namespace waymark
