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

/// The measurements needed again: those after the oldest mark, the newest of each sensor, the last reported one.
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

}  // namespace

void Fusion::save(OutArchive& out) const {
  Parts& p = *parts_;
  out.section("fusion", 4);
  for (const fusion::SensorRecord& sensor : p.committed.sensors) out.value(std::string_view(sensor.slot.name));
  out.value(p.arrived);
  out.value(p.started);
  if (!p.started) return;  // the log is read again from its beginning
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
    out(p.committed.mark(0));
    p.committed.smoother.save(p.committed.smoother.size(), out);
  } else {
    const fusion::Mark& mark = p.history.marks().front();
    out.value(mark.at);
    out.value(mark.stamp);
    p.committed.filter.save(mark.filter, out);
    out(mark);
    p.committed.smoother.save(mark.smoothed, out);
  }
}

void Fusion::resume(InArchive& in, const Next& next) {
  Parts& p = *parts_;
  if (in.section("fusion", 4) < 4) throw DataError("the checkpoint is of an older kind");
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
  serialize(p.datum, in);
  std::vector<Event> events;
  serialize(events, in);
  serialize(p.arrival_events, in);
  std::vector<std::uint64_t> processed_late(p.committed.sensors.size());
  for (std::size_t i = 0; i < processed_late.size(); ++i) {
    in.value(p.committed.sensors[i].too_late_noted);
    in.value(processed_late[i]);
  }
  p.maps.load(in, p.committed.filter);
  Needed needed;
  Fate fate{};
  in(needed);
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
  in(mark);
  p.committed.smoother.load(in);

  // Reads the log again, through clock checks and queue only: processed measurements are in the checkpoint.
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
