// SPDX-License-Identifier: Apache-2.0
// Before the start: measurements are kept until pose and motion are known, then processed in their order.
#include <algorithm>

#include "fusion/parts.hpp"

namespace waymark {

void Fusion::Parts::await_start(const Measurement& m) {
  committed.last_stamp = std::max(committed.last_stamp, m.stamp);
  const auto hint = startup.looks_for_pose() ? steps.start_hint(m) : std::nullopt;
  if (const auto start = startup.consider(m, hint, committed.sensors)) begin(*start);
}

void Fusion::Parts::begin(const fusion::Start& start) {
  committed.filter.start(start.prior, start.draw);
  committed.filter.mixture();  // the front may be asked for before anything is committed
  started = true;
  committed.health.start(start.prior.stamp);
  for (const Measurement& m : startup.release()) {
    const bool before = m.stamp < start.prior.stamp;
    // Its turns and stretches count from the first measurement.
    if (before) committed.record(m).state.fuse.fuses(m.stamp);
    if (start.used && m.sensor == start.used_sensor && m.sequence == start.used_sequence) {
      committed.count(m, Fate::fused);  // it is in the start pose
      show(m, Fate::fused);
    } else if (before) {
      committed.count(m, Fate::before_start);
      show(m, Fate::before_start);
    } else {
      commit(m);
    }
  }
}

void Fusion::finish() {
  Parts& p = *parts_;
  p.intake.finish([&](const Measurement& m, bool is_late) { p.take_turn(m, is_late); });
  if (p.started) return;
  for (const Measurement& m : p.startup.release()) p.committed.count(m, Fate::before_start);
  p.committed.note(p.committed.last_stamp,
                   "the filter never started: " + (p.arrived == 0 ? "no measurement has come" : p.startup.missing()));
}

}  // namespace waymark
