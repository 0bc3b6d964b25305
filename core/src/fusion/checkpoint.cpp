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

void save_events(const std::vector<Event>& events, OutArchive& out) {
  out.value(static_cast<std::uint64_t>(events.size()));
  for (const Event& event : events) {
    out.value(std::string_view(event.text));
    out.value(event.stamp_s);
    out.value(event.is_failure);
  }
}

void load_events(std::vector<Event>& events, InArchive& in) {
  std::uint64_t count = 0;
  in.value(count);
  events.clear();
  for (std::uint64_t i = 0; i < count; ++i) {
    Event& event = events.emplace_back();
    in.value(event.text);
    in.value(event.stamp_s);
    in.value(event.is_failure);
  }
}

void save_datum(const std::optional<Datum>& datum, OutArchive& out) {
  const Datum value = datum.value_or(Datum{});
  out.value(datum.has_value());
  for (const double coordinate : {value.latitude_deg, value.longitude_deg, value.height_m}) out.value(coordinate);
}

void load_datum(std::optional<Datum>& datum, InArchive& in) {
  bool has_datum = false;
  Datum value;
  in.value(has_datum);
  for (double* coordinate : {&value.latitude_deg, &value.longitude_deg, &value.height_m}) in.value(*coordinate);
  if (has_datum) datum = value;
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

  void save(OutArchive& out) const {
    for (const NeededMeasurements* each : {&after_mark, &newest, &last}) each->save(out);
  }
  void load(InArchive& in) {
    for (NeededMeasurements* each : {&after_mark, &newest, &last}) each->load(in);
  }
  void offer(const Measurement& m) {
    for (NeededMeasurements* each : {&after_mark, &newest, &last}) each->offer(m);
  }
  void check() const {
    for (const NeededMeasurements* each : {&after_mark, &newest, &last}) each->check();
  }
};

}  // namespace

void Fusion::save(OutArchive& out) const {
  const Parts& p = *parts_;
  out.section("fusion", 3);
  for (const fusion::SensorRecord& sensor : p.committed.sensors) out.value(std::string_view(sensor.slot.name));
  out.value(p.arrived);
  out.value(p.started);
  if (!p.started) return;  // reading again from the beginning is all it takes
  out.value(p.turns);
  save_datum(p.datum, out);
  save_events(p.committed.events, out);
  save_events(p.arrival_events, out);
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
  needed.save(out);
  out.value(p.last ? p.last->second : Fate::ignored);

  if (p.history.marks().empty()) {
    p.committed.filter.save(out);
    p.committed.save(p.committed.mark(0), out);
  } else {
    const fusion::Mark& mark = p.history.marks().front();
    out.value(mark.at);
    out.value(mark.stamp);
    p.committed.filter.save(mark.filter, out);
    p.committed.save(mark, out);
  }
}

void Fusion::resume(InArchive& in, const Next& next) {
  Parts& p = *parts_;
  if (in.section("fusion", 3) < 3) throw DataError("the checkpoint is of an older kind");
  check_sensor_names(p.committed.sensors, in);
  std::uint64_t arrived = 0;
  bool started = false;
  in.value(arrived);
  in.value(started);
  const auto next_again = [&] {
    auto m = next();
    if (!m) throw DataError("the log ends before the checkpoint: it is another log");
    return std::move(*m);
  };
  p.repeating = true;
  if (!started) {
    for (std::uint64_t i = 0; i < arrived; ++i) add(next_again());
    p.repeating = false;
    return;
  }
  std::uint64_t turns = 0;
  in.value(turns);
  load_datum(p.datum, in);
  std::vector<Event> events;
  load_events(events, in);
  load_events(p.arrival_events, in);
  std::vector<std::uint64_t> processed_late(p.committed.sensors.size());
  for (std::size_t i = 0; i < processed_late.size(); ++i) {
    in.value(p.committed.sensors[i].too_late_noted);
    in.value(processed_late[i]);
  }
  p.maps.load(in, p.committed.filter);
  Needed needed;
  Fate fate{};
  needed.load(in);
  in.value(fate);

  fusion::Mark mark = p.committed.mark(0);
  const bool has_marks = p.maps.empty() && p.history.keeps();
  if (has_marks) {
    in.value(mark.at);
    in.value(mark.stamp);
    mark.filter = p.committed.filter.load_state(in);
  } else {
    p.committed.filter.load(in);
  }
  p.committed.load(mark, in);
  p.committed.smoother.load(in);

  // The log again, through the clocks and the queue only: what was processed is in the checkpoint.
  for (; p.arrived < arrived; ++p.arrived) {
    Measurement m = next_again();
    fusion::SensorRecord& sensor = p.committed.record(m);
    m.stamp -= sensor.slot.delay;
    const auto turn = [&](const Measurement& taken, bool) {
      ++p.turns;
      needed.offer(taken);
    };
    if (p.intake.admit(m, turn)) ++sensor.mistimed;
  }
  if (p.turns != turns) throw DataError("the log gives other measurements than the checkpoint's: it is another log");
  needed.check();

  p.started = true;
  for (Measurement& m : needed.newest.found()) p.committed.record(m).newest = std::move(m);
  if (has_marks) {
    p.history.begin(std::move(mark));
    p.committed.events = std::move(events);
    p.committed.roll_back(p.history.marks().front());
    for (const Measurement& m : needed.after_mark.found()) p.predict_and_process(m);
  } else {
    p.committed.take(std::move(mark));
    p.committed.events = std::move(events);
  }
  for (std::size_t i = 0; i < processed_late.size(); ++i) {
    p.committed.sensors[i].state.counters.processed_late = processed_late[i];
  }
  p.committed.judge_health(p.committed.filter.stamp());
  if (!needed.last.found().empty()) p.last = {std::move(needed.last.found().front()), fate};
  p.repeating = false;
}

}  // namespace waymark
