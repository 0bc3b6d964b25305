// SPDX-License-Identifier: Apache-2.0
// A checkpoint: the committed side, to go on from later. Without maps it begins at the oldest mark, so that what comes
// late afterwards finds the same marks to roll back to.
#include <fmt/format.h>

#include <string>
#include <utility>

#include "fusion/needed_measurements.hpp"
#include "fusion/parts.hpp"
#include "waymark/base/error.hpp"

namespace waymark {

using fusion::NeededMeasurements;

namespace {

template <class Archive>
void serialize(std::vector<Event>& events, Archive& archive) {
  auto count = static_cast<std::uint64_t>(events.size());
  archive(count);
  if constexpr (Archive::kReads) events.clear();
  for (std::uint64_t i = 0; i < count; ++i) {
    if constexpr (Archive::kReads) events.emplace_back();
    Event& event = events[i];
    archive(event.text, event.stamp_s, event.is_failure);
  }
}

template <class Archive>
void serialize(std::optional<Datum>& datum, Archive& archive) {
  bool is_known = datum.has_value();
  archive(is_known);
  if (!is_known) return;
  if (!datum) datum.emplace();
  archive(datum->latitude_deg, datum->longitude_deg, datum->height_m);
}

void check_sensor_names(const std::vector<fusion::SensorRecord>& sensors, InArchive& in) {
  for (const fusion::SensorRecord& sensor : sensors) {
    std::string name;
    in.value(name);
    if (name != sensor.slot.name) {
      throw DataError(
          fmt::format("the checkpoint was made with a sensor \"{}\" where now \"{}\" stands", name, sensor.slot.name));
    }
  }
}

/// Which measurements are needed again: those after the oldest mark, the newest of each sensor, the last one shown.
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
  p.committed.judge_health(p.committed.filter.stamp());
  if (!needed.last.found().empty()) p.last = {std::move(needed.last.found().front()), fate};
}

}  // namespace

void Fusion::save(OutArchive& out) const {
  Parts& p = *parts_;
  out.section("fusion", 4);
  for (const fusion::SensorRecord& sensor : p.committed.sensors) out.value(std::string_view(sensor.slot.name));
  out.value(p.arrived);
  out.value(p.started);
  if (!p.started) return;  // reading again from the beginning is all it takes
  out.value(p.turns);
  serialize(p.datum, out);
  serialize(p.committed.events, out);
  serialize(p.arrival_events, out);
  for (const fusion::SensorRecord& sensor : p.committed.sensors) {
    out.value(sensor.too_late_noted);
    out.value(sensor.state.counters.processed_late);
  }
  p.maps.save(out);

  Needed needed;
  for (const Measurement& m : p.history.log()) needed.after_mark.want(m);
  for (const fusion::SensorRecord& sensor : p.committed.sensors) {
    if (sensor.newest) needed.newest.want(*sensor.newest);
  }
  if (p.last) needed.last.want(p.last->first);
  out(needed);
  out.value(p.last ? p.last->second : Fate::ignored);

  if (p.history.marks().empty()) {
    p.committed.filter.save(out);
    out(p.committed.mark_without_filter());
    p.committed.smoother.serialize(out, p.committed.smoother.size());
  } else {
    fusion::Mark& mark = p.history.oldest_mark();
    out(mark.at, mark.stamp);
    p.committed.filter.serialize(out, mark.filter);
    out(mark);
    p.committed.smoother.serialize(out, mark.smoothed);
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
