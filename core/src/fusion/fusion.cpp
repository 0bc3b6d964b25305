// SPDX-License-Identifier: Apache-2.0
#include "waymark/host/fusion.hpp"

#include <fmt/format.h>

#include <exception>

#include "fusion/parts.hpp"
#include "fusion/snapshot_view.hpp"
#include "waymark/base/error.hpp"

// Fig. 2.1 of the paper: every measurement predicts; its sensor's updates are innovated, gated and applied; the maps
// that it triggers extract, refine, sample, weigh, insert and resample; the observer gets a snapshot.

namespace waymark {

using fusion::Horizon;
using fusion::UpdateResult;

// --- admit -----------------------------------------------------------------------------------------------------------

void Fusion::add(Measurement m) {
  Parts& p = *parts_;
  ++p.arrived;
  const fusion::SensorRecord& sensor = p.committed.record(m);
  sensor.correct_delay(m);
  const auto turn = [&](const Measurement& next, bool is_late) { p.dispatch(next, is_late); };
  if (const auto fault = p.intake.admit(m, sensor.slot.delay, turn)) p.reject(m, *fault);
}

void Fusion::Parts::dispatch(const Measurement& m, bool is_late) {
  ++turns;
  // Equal stamps are ordered only within the latency window; without one the order of arrival is sufficient for maps.
  const bool has_current_stamp = has_pose() && !maps.empty() && m.stamp == committed.filter.stamp();
  if (!has_pose()) {
    await_start(m);
  } else if (is_late && !has_current_stamp) {
    process_late(m);
  } else {
    commit(m);
  }
}

void Fusion::Parts::commit(const Measurement& m) {
  if (is_after_gap(m)) {
    lose_pose(m.stamp, fmt::format("no measurement for {:.3g} s", to_seconds(m.stamp - committed.filter.stamp())));
    await_start(m);
    return;
  }
  const Fate fate = predict_and_process(m);
  if (committed.unsound) {
    lose_pose(m.stamp, kUnsound);
  } else if (const auto place = committed.filter.take_place()) {
    begin_at(m.stamp, *place);
  }
  committed.update_health(m.stamp);
  notify_observer(m, fate);
}

// --- predict ---------------------------------------------------------------------------------------------------------

Fate Fusion::Parts::predict_and_process(const Measurement& m) {
  mark_if_due();
  if (history.keeps()) history.append(m);
  committed.last_stamp = m.stamp;
  if (committed.standstill.lapses(m.stamp)) {
    committed.filter.release(settings.start.velocity_sigma, settings.start.rate_sigma);
    if (settings.smooth) committed.smoother.amend(committed.filter.mixture(), false);
  }
  committed.filter.predict(m.stamp, committed.standstill.standing());

  const Fate fate = process(m, present, layout, updates);
  committed.count(m, fate);
  committed.unsound = committed.unsound || !committed.filter.has_plausible_variances();
  if (committed.unsound) return fate;
  if (maps.empty()) {
    committed.filter.record_path();
  } else {
    committed.filter.remember();
  }
  if (settings.smooth) add_to_smoother(fate);
  return fate;
}

// --- for each update: innovate, gate, update -------------------------------------------------------------------------

namespace {

void apply_updates(const Measurement& m, Horizon& at, const StateLayout& layout, UpdateList& updates,
                   UpdateResult& result) {
  const Datum* datum = at.datum(m);
  Sensor* sensor = at.sensor(m);
  if (sensor == nullptr) return;
  const Belief& belief = at.belief();
  const double* block = belief.mean.block.data() + layout.block_offset(static_cast<int>(m.sensor));
  updates.clear();
  try {
    sensor->process(m, {belief, layout, block, datum, at.standing()}, updates);
    result.degraded_reason = updates.degraded_reason();
    // A degraded measurement without updates counts as rejected.
    result.fate = updates.size() == 0 && !result.degraded_reason.empty() ? Fate::gated : Fate::fused;
    result.nis_is_trivial = at.steers(m) && updates.twist_reset().has_value();
    result.is_continuous = updates.is_continuous();
    if (at.steers(m) && at.follow_motion(m, updates)) return;
    for (std::size_t i = 0; i < updates.size(); ++i) at.update(m, i, updates[i], result);
  } catch (const DataError& error) {
    result.degraded_reason = updates.degraded_reason();
    result.fate = Fate::unusable;
    at.note_unusable(m, error.what());
  } catch (const std::exception& error) {
    result.fate = Fate::ignored;
    at.take_out_of_service(m, error.what());
  } catch (...) {
    result.fate = Fate::ignored;
    at.take_out_of_service(m, "unknown exception");
  }
}

// --- extract, refine, sample, weigh, insert, resample ----------------------------------------------------------------

void apply_maps(const Measurement& m, Horizon& at, UpdateResult& result) {
  const fusion::Extraction extraction = at.extract(m);
  if (extraction.unusable) result.fate = Fate::unusable;
  if (!extraction.inputs.empty()) {
    at.map(m, extraction, result);
  } else if (extraction.skipped) {
    at.skip_mapping();
    if (result.fate == Fate::ignored) result.fate = Fate::skipped;
  } else if (extraction.held_out && result.fate == Fate::ignored) {
    result.fate = Fate::held_out;
  }
}

}  // namespace

Fate process(const Measurement& m, Horizon& at, const StateLayout& layout, UpdateList& updates) {
  UpdateResult result{.fate = Fate::held_out};
  if (at.fuses(m)) {
    result.fate = Fate::ignored;
    if (at.sensor(m) != nullptr) apply_updates(m, at, layout, updates, result);
    if (at.steers(m)) {
      apply_maps(m, at, result);
    } else {
      result.fate = Fate::held_out;
    }
  }
  at.conclude(m, result);
  return result.fate;
}

// --- notify ----------------------------------------------------------------------------------------------------------

void Fusion::Parts::notify_observer(const Measurement& m, Fate fate) {
  last = {m, fate};
  if (observer && !repeating) {
    if (has_pose()) committed.filter.reported();
    observer(fusion::SnapshotView(committed, maps.maps(), has_pose(), m, fate, datum));
  }
}

/// The front: buffered measurements take the same steps, with one Gaussian and without maps.
Belief Fusion::front(Time at) const {
  const Parts& p = *parts_;
  if (!p.has_pose()) throw Error(p.started ? "the pose is lost" : "the filter has not started");
  if (at < p.committed.filter.stamp()) {
    throw Error(fmt::format("a pose at {} was requested, before the committed time ({})", format_time(at),
                            format_time(p.committed.filter.stamp())));
  }
  fusion::FrontHorizon front(p.committed, p.process_model, p.datum);
  UpdateList updates;
  for (const Measurement& m : p.intake.queue().waiting()) {
    if (m.stamp > at) break;
    front.predict(m.stamp);
    process(m, front, p.layout, updates);
  }
  return front.predicted(at);
}

}  // namespace waymark
