// SPDX-License-Identifier: Apache-2.0
// Checkpoints of the committed state. Without maps a checkpoint begins at the oldest mark, so that later late
// measurements roll back to the same marks.
#include <fmt/format.h>

#include <string>
#include <utility>

#include "fusion/needed_measurements.hpp"
#include "fusion/parts.hpp"
#include "waymark/base/error.hpp"

namespace waymark {

using fusion::NeededMeasurements;

namespace {

/// What stands in front of the committed side.
struct Progress {
  std::uint64_t arrived = 0;
  bool started = false;
  std::uint64_t turns = 0;
  std::vector<Event> events;
  std::vector<std::uint64_t> processed_late;  ///< per sensor
};

template <class Archive>
void serialize_sensor_names(Archive& archive, const std::vector<fusion::SensorRecord>& sensors) {
  for (const fusion::SensorRecord& sensor : sensors) {
    std::string name = sensor.slot.name;
    archive(name);
    if (name != sensor.slot.name) {
      throw DataError(
          fmt::format("the checkpoint was made with a sensor \"{}\" where now \"{}\" stands", name, sensor.slot.name));
    }
  }
}

/// Of a host that has not started only how many measurements arrived: reading those again is all it takes.
template <class Archive, class Parts>
void serialize_progress(Archive& archive, Parts& p, Progress& progress) {
  if (archive.section("fusion", 4) < 4) throw DataError("the checkpoint has an older version");
  serialize_sensor_names(archive, p.committed.sensors);
  archive(progress.arrived, progress.started);
  if (!progress.started) return;
  archive(progress.turns, p.datum, progress.events, p.arrival_events);
  progress.processed_late.resize(p.committed.sensors.size());
  for (std::size_t i = 0; i < p.committed.sensors.size(); ++i)
    archive(p.committed.sensors[i].too_late_noted, progress.processed_late[i]);
  p.maps.serialize(archive, p.committed.filter);
}

/// Which measurements are needed again: those after the oldest mark, the newest of each sensor, the last one reported.
struct Needed {
  NeededMeasurements after_mark;
  NeededMeasurements newest;
  NeededMeasurements last;

  template <class Archive>
  void serialize(Archive& archive) {
    archive(after_mark, newest, last);
  }
  void offer(const Measurement& m) {
    for (NeededMeasurements* each : {&after_mark, &newest, &last}) each->offer(m);
  }
  void check() const {
    for (const NeededMeasurements* each : {&after_mark, &newest, &last}) each->check();
  }
};

void serialize_filter(OutArchive& out, const particles::ParticleFilter& filter) { filter.save(out); }
void serialize_filter(InArchive& in, particles::ParticleFilter& filter) { filter.load(in); }

/// The committed side: with marks as it was at the oldest, which `mark` is, else as it is.
template <class Archive>
void serialize_committed(Archive& archive, fusion::Committed& committed, fusion::Mark& mark, bool has_marks) {
  if (has_marks) {
    archive(mark.at, mark.stamp);
    committed.filter.serialize(archive, mark.filter);
  } else {
    serialize_filter(archive, committed.filter);
  }
  archive(mark);
  committed.smoother.serialize(archive, mark.smoothed);
}

Measurement next_again(const Fusion::Next& next) {
  auto m = next();
  if (!m) throw DataError("the log ends before the checkpoint: it is another log");
  return std::move(*m);
}

/// The log again, through the clocks and the queue only: what was processed is in the checkpoint.
template <class Parts>
void repeat_arrivals(Parts& p, const Progress& progress, Needed& needed, const Fusion::Next& next) {
  const auto turn = [&](const Measurement& taken, bool) {
    ++p.turns;
    needed.offer(taken);
  };
  for (; p.arrived < progress.arrived; ++p.arrived) {
    Measurement m = next_again(next);
    fusion::SensorRecord& sensor = p.committed.record(m);
    m.stamp -= sensor.slot.delay;
    if (p.intake.admit(m, turn)) ++sensor.mistimed;
  }
  if (p.turns != progress.turns)
    throw DataError("the log gives other measurements than the checkpoint's: it is another log");
  needed.check();
}

template <class Parts>
void resume_started(InArchive& in, Parts& p, Progress& progress, const Fusion::Next& next) {
  Needed needed;
  Fate fate{};
  in(needed, fate);
  fusion::Mark mark = p.committed.mark_without_filter();
  const bool has_marks = p.maps.empty() && p.history.keeps();
  serialize_committed(in, p.committed, mark, has_marks);
  repeat_arrivals(p, progress, needed, next);

  p.started = true;
  for (Measurement& m : needed.newest.found()) p.committed.record(m).newest = std::move(m);
  if (has_marks) {
    p.history.begin(std::move(mark));
    p.committed.events = std::move(progress.events);
    p.committed.roll_back(p.history.marks().front());
    for (const Measurement& m : needed.after_mark.found()) p.predict_and_process(m);
  } else {
    p.committed.take(std::move(mark));
    p.committed.events = std::move(progress.events);
  }
  for (std::size_t i = 0; i < progress.processed_late.size(); ++i)
    p.committed.sensors[i].state.counters.processed_late = progress.processed_late[i];
  p.committed.update_health(p.committed.filter.stamp());
  if (!needed.last.found().empty()) p.last = {std::move(needed.last.found().front()), fate};
}

}  // namespace

void Fusion::save(OutArchive& out) const {
  Parts& p = *parts_;
  Progress progress{p.arrived, p.started, p.turns, p.committed.events, {}};
  for (const fusion::SensorRecord& sensor : p.committed.sensors)
    progress.processed_late.push_back(sensor.state.counters.processed_late);
  serialize_progress(out, p, progress);
  if (!p.started) return;

  Needed needed;
  for (const Measurement& m : p.history.log()) needed.after_mark.want(m);
  for (const fusion::SensorRecord& sensor : p.committed.sensors) {
    if (sensor.newest) needed.newest.want(*sensor.newest);
  }
  if (p.last) needed.last.want(p.last->first);
  out(needed, p.last ? p.last->second : Fate::ignored);

  if (p.history.marks().empty()) {
    fusion::Mark now = p.committed.mark_without_filter();
    serialize_committed(out, p.committed, now, false);
  } else {
    serialize_committed(out, p.committed, p.history.oldest_mark(), true);
  }
}

void Fusion::resume(InArchive& in, const Next& next) {
  Parts& p = *parts_;
  Progress progress;
  serialize_progress(in, p, progress);
  p.repeating = true;
  if (progress.started) {
    resume_started(in, p, progress, next);
  } else {
    for (std::uint64_t i = 0; i < progress.arrived; ++i) add(next_again(next));
  }
  p.repeating = false;
}

}  // namespace waymark
