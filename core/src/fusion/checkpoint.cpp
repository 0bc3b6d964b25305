// SPDX-License-Identifier: Apache-2.0
// Checkpoints of the committed state. Without maps a checkpoint begins at the oldest mark, so that later late
// measurements roll back to the same marks.
#include <fmt/format.h>

#include <string>
#include <utility>

#include "fusion/measurement_archive.hpp"
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

/// What a rollback leaves alone.
template <class Archive>
void serialize_counted(Archive& archive, fusion::SensorRecord& sensor, std::uint64_t& processed_late) {
  auto mode = static_cast<std::uint8_t>(sensor.mode);
  archive(sensor.too_late_noted, processed_late, mode);
  if (mode > static_cast<std::uint8_t>(SensorMode::off)) throw DataError("the checkpoint has an unknown sensor mode");
  sensor.mode = static_cast<SensorMode>(mode);
  sensor.policy.evaluate_only = sensor.mode == SensorMode::shadow;
}

/// Of a host that has no pose, not yet or not any more, only how many measurements arrived: reading those again is all
/// it takes.
template <class Archive, class Parts>
void serialize_progress(Archive& archive, Parts& p, Progress& progress) {
  if (archive.section("fusion", 7) < 7) throw DataError("the checkpoint has an older version");
  serialize_sensor_names(archive, p.committed.sensors);
  archive(progress.arrived, progress.started);
  if (!progress.started) return;
  archive(progress.turns, p.datum, progress.events, p.arrival_events);
  progress.processed_late.resize(p.committed.sensors.size());
  for (std::size_t i = 0; i < p.committed.sensors.size(); ++i)
    serialize_counted(archive, p.committed.sensors[i], progress.processed_late[i]);
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
  const Time now = has_marks ? mark.filter.particles.front().belief.stamp : committed.filter.stamp();
  committed.smoother.serialize(archive, mark.smoothed, now);
}

/// Throws DataError if a mark that was read is not one of this host with so many events.
void require_mark(const fusion::Mark& mark, std::size_t events, bool has_marks) {
  if (mark.events > events) throw DataError("the checkpoint has fewer events than announced");
  if (has_marks && mark.filter.particles.front().belief.stamp > mark.stamp)
    throw DataError("the checkpoint has particles that are ahead of their time");
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
    sensor.correct_delay(m);
    if (p.intake.admit(m, sensor.slot.delay, turn)) {
      ++sensor.mistimed;
      needed.last.offer(m);  // also what was rejected is reported
    }
  }
  if (p.turns != progress.turns)
    throw DataError("the log gives other measurements than the checkpoint's: it is another log");
  needed.check();
}

/// Measurements after a mark are processed again, in their order, from the mark's particles on.
template <class Parts>
void process_again(Parts& p, const std::vector<Measurement>& measurements) {
  const fusion::MeasurementQueue::Order precedes;
  for (std::size_t i = 0; i < measurements.size(); ++i) {
    const bool is_next =
        i == 0 ? measurements[i].stamp >= p.committed.filter.stamp() : precedes(measurements[i - 1], measurements[i]);
    if (!is_next) throw DataError("the checkpoint needs measurements that are not in order: it is of another log");
    p.predict_and_process(measurements[i]);
  }
}

/// `repeat`: brings the arrivals of before to the parts, and those that are needed to `Needed`.
template <class Parts, class Repeat>
void resume_started(InArchive& in, Parts& p, Progress& progress, const Repeat& repeat) {
  Needed needed;
  Fate fate{};
  in(needed, fate);
  fusion::Mark mark = p.committed.mark_without_filter();
  const bool has_marks = p.maps.empty() && p.history.keeps();
  serialize_committed(in, p.committed, mark, has_marks);
  require_mark(mark, progress.events.size(), has_marks);
  repeat(needed);

  p.started = true;
  for (Measurement& m : needed.newest.found()) p.committed.record(m).newest = std::move(m);
  if (has_marks) {
    p.history.begin(std::move(mark));
    p.committed.events = std::move(progress.events);
    p.committed.roll_back(p.history.marks().front());
    process_again(p, needed.after_mark.found());
  } else {
    p.committed.take(std::move(mark));
    p.committed.events = std::move(progress.events);
  }
  if (p.committed.filter.stamp() != p.intake.queue().newest_returned())
    throw DataError("the log ends at another time than the checkpoint: it is another log");
  for (std::size_t i = 0; i < progress.processed_late.size(); ++i)
    p.committed.sensors[i].state.counters.processed_late = progress.processed_late[i];
  p.committed.update_health(p.committed.filter.stamp());
  // The run before has taken them.
  p.new_arrival_events.skip(p.arrival_events);
  p.committed.new_events.skip(p.committed.events);
  if (!needed.last.found().empty()) p.last = {std::move(needed.last.found().front()), fate};
}

/// What came before, of a running robot: nobody can repeat it.
template <class Archive, class Parts>
void serialize_arrivals(Archive& archive, Parts& p) {
  if (archive.section("arrivals", 2) < 2) throw DataError("the checkpoint has an older version");
  archive(p.intake);
  for (fusion::SensorRecord& sensor : p.committed.sensors) archive(sensor.mistimed);
}

template <class Measurements>
void write_all(OutArchive& out, const Measurements& measurements) {
  out(static_cast<std::uint64_t>(measurements.size()));
  for (const Measurement& m : measurements) fusion::write_measurement(out, m);
}

template <class Use>
void read_all(InArchive& in, std::size_t sensors, const Use& use) {
  std::uint64_t count = 0;
  in(count);
  for (std::uint64_t i = 0; i < count; ++i) {
    Measurement m = fusion::read_measurement(in);
    if (m.sensor >= sensors) throw DataError("the checkpoint has a measurement of an unknown sensor");
    use(std::move(m));
  }
}

}  // namespace

void Fusion::save(OutArchive& out) const {
  Parts& p = *parts_;
  Progress progress{p.arrived, p.has_pose(), p.turns, p.committed.events, {}};
  for (const fusion::SensorRecord& sensor : p.committed.sensors)
    progress.processed_late.push_back(sensor.state.counters.processed_late);
  serialize_progress(out, p, progress);
  if (!p.has_pose()) return;

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

void Fusion::save_with_measurements(OutArchive& out, std::span<const Measurement> waiting) const {
  Parts& p = *parts_;
  if (!p.has_pose()) throw Error("there is no pose");
  save(out);
  serialize_arrivals(out, p);
  std::vector<Measurement> needed(p.history.log().begin(), p.history.log().end());
  for (const fusion::SensorRecord& sensor : p.committed.sensors) {
    if (sensor.newest) needed.push_back(*sensor.newest);
  }
  if (p.last) needed.push_back(p.last->first);
  write_all(out, needed);
  write_all(out, p.intake.queue().waiting());
  write_all(out, waiting);
}

std::vector<Measurement> Fusion::resume_with_measurements(InArchive& in) {
  Parts& p = *parts_;
  Progress progress;
  std::vector<Measurement> waiting;
  serialize_progress(in, p, progress);
  if (!progress.started) throw DataError("the checkpoint was made before the filter started");
  p.repeating = true;
  resume_started(in, p, progress, [&](Needed& needed) {
    serialize_arrivals(in, p);
    const std::size_t sensors = p.committed.sensors.size();
    read_all(in, sensors, [&](Measurement&& m) { needed.offer(m); });
    needed.check();
    read_all(in, sensors, [&](Measurement&& m) { p.intake.put_back(std::move(m)); });
    read_all(in, sensors, [&](Measurement&& m) { waiting.push_back(std::move(m)); });
    p.arrived = progress.arrived;
    p.turns = progress.turns;
  });
  p.repeating = false;
  return waiting;
}

void Fusion::resume(InArchive& in, const Next& next) {
  Parts& p = *parts_;
  Progress progress;
  serialize_progress(in, p, progress);
  p.repeating = true;
  if (progress.started) {
    resume_started(in, p, progress, [&](Needed& needed) { repeat_arrivals(p, progress, needed, next); });
  } else {
    for (std::uint64_t i = 0; i < progress.arrived; ++i) add(next_again(next));
  }
  p.repeating = false;
}

}  // namespace waymark
