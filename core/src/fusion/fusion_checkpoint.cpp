// SPDX-License-Identifier: Apache-2.0
// A checkpoint holds no measurement: those that are still needed are read from the log again, which is exact and needs
// no format of its own. Without maps it begins at the oldest mark, so that what comes late afterwards finds the same
// marks to go back to.
#include <fmt/format.h>

#include <utility>

#include "fusion/fusion_impl.hpp"
#include "waymark/base/error.hpp"

namespace waymark {

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

}  // namespace

/// Measurements by (sensor, sequence), in the order in which they are given.
struct Fusion::Impl::Needed {
  std::vector<std::pair<std::uint32_t, std::uint64_t>> keys;
  std::vector<Measurement> found;

  void want(const Measurement& m) { keys.emplace_back(m.sensor, m.sequence); }
  void offer(const Measurement& m) {
    for (std::size_t i = 0; i < keys.size(); ++i) {
      if (keys[i] == std::pair(m.sensor, m.sequence)) found[i] = m;
    }
  }
  void save(OutArchive& out) const {
    out.value(static_cast<std::uint64_t>(keys.size()));
    for (const auto& [sensor, sequence] : keys) {
      out.value(sensor);
      out.value(sequence);
    }
  }
  void load(InArchive& in) {
    std::uint64_t count = 0;
    in.value(count);
    keys.clear();
    for (std::uint64_t i = 0; i < count; ++i) {
      auto& [sensor, sequence] = keys.emplace_back();
      in.value(sensor);
      in.value(sequence);
    }
    found.assign(keys.size(), {});
  }
  /// Throws DataError if the log did not hold them all.
  void check() const {
    for (std::size_t i = 0; i < keys.size(); ++i) {
      if (found[i].payload == nullptr) {
        throw DataError(
            fmt::format("the log lacks measurement {} that the checkpoint needs: it is another log", keys[i].second));
      }
    }
  }
};

/// The maps' modules; their maps are the particles'.
void Fusion::Impl::save_modules(OutArchive& out) const {
  out.value(static_cast<std::uint64_t>(maps_.size()));
  for (std::size_t i = 0; i < maps_.size(); ++i) {
    out.value(std::string_view(maps_[i].name));
    out.value(unusable_to_[i]);
    out.value(maps_[i].module != nullptr);
    if (maps_[i].module) maps_[i].module->save(out);
  }
}

void Fusion::Impl::load_modules(InArchive& in) {
  std::uint64_t count = 0;
  in.value(count);
  if (count != maps_.size())
    throw DataError(fmt::format("the checkpoint has {} maps, the configuration {}", count, maps_.size()));
  for (std::size_t i = 0; i < maps_.size(); ++i) {
    MapSlot& map = maps_[i];
    std::string name;
    in.value(name);
    if (name != map.name)
      throw DataError(fmt::format("the checkpoint was made with a map \"{}\" where now \"{}\" stands", name, map.name));
    in.value(unusable_to_[i]);
    bool in_service = false;
    in.value(in_service);
    if (in_service) {
      map.module->load(in);
    } else {
      map.module = nullptr;
      filter_.drop_module(static_cast<int>(i));
    }
  }
}

void Fusion::Impl::save(OutArchive& out) const {
  out.section("fusion", 2);
  for (const SensorPart& part : parts_) out.value(std::string_view(part.slot.name));
  out.value(arrived_);
  out.value(started_);
  if (!started_) return;  // reading again from the beginning is all it takes
  out.value(steps_);
  const Datum datum = datum_.value_or(Datum{});
  out.value(datum_.has_value());
  for (const double value : {datum.latitude_deg, datum.longitude_deg, datum.height_m}) out.value(value);
  save_events(events_, out);
  save_events(arrival_events_, out);
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    out.value(parts_[i].told_late);
    out.value(committed_.sensors[i].counters.taken_in_late);
  }
  save_modules(out);

  Needed again;
  Needed newest;
  for (const Measurement& m : history_.log()) again.want(m);
  for (const auto& m : newest_) {
    if (m) newest.want(*m);
  }
  again.save(out);
  newest.save(out);
  const Fate fate = last_ ? last_->second : Fate::unheard;
  Needed last;
  if (last_) last.want(last_->first);
  last.save(out);
  out.value(fate);

  if (history_.marks().empty()) {
    filter_.save(out);
    committed_.save(out);
    smoother_.save(smoother_.size(), out);
  } else {
    const Mark& mark = history_.marks().front();
    out.value(mark.at);
    out.value(mark.stamp);
    filter_.save(mark.filter, out);
    mark.committed.save(out);
    smoother_.save(mark.committed.smoothed, out);
  }
}

void Fusion::Impl::resume(InArchive& in, const Next& next) {
  if (in.section("fusion", 2) < 2) throw DataError("the checkpoint is of an older kind");
  for (const SensorPart& part : parts_) {
    std::string name;
    in.value(name);
    if (name != part.slot.name) {
      throw DataError(
          fmt::format("the checkpoint was made with a sensor \"{}\" where now \"{}\" stands", name, part.slot.name));
    }
  }
  std::uint64_t arrived = 0;
  bool started = false;
  in.value(arrived);
  in.value(started);
  const auto read_again = [&] {
    for (std::uint64_t i = 0; i < arrived; ++i) {
      auto m = next();
      if (!m) throw DataError("the log ends before the checkpoint: it is another log");
      add(std::move(*m));
    }
  };
  redoing_ = true;
  if (!started) {
    read_again();
    redoing_ = false;
    return;
  }
  in.value(skip_);
  bool has_datum = false;
  Datum datum;
  in.value(has_datum);
  for (double* value : {&datum.latitude_deg, &datum.longitude_deg, &datum.height_m}) in.value(*value);
  if (has_datum) datum_ = datum;
  std::vector<Event> events;
  std::vector<Event> arrival_events;
  load_events(events, in);
  load_events(arrival_events, in);
  std::vector<std::uint64_t> taken_in_late(parts_.size());
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    in.value(parts_[i].told_late);
    in.value(taken_in_late[i]);
  }
  load_modules(in);
  Needed again;
  Needed newest;
  Needed last;
  Fate fate{};
  again.load(in);
  newest.load(in);
  last.load(in);
  in.value(fate);

  Mark mark{0, {}, {}, committed_.clone()};
  if (maps_.empty() && history_.keeps()) {
    in.value(mark.at);
    in.value(mark.stamp);
    mark.filter = filter_.load_state(in);
    mark.committed.load(in);
    smoother_.load(in);
  } else {
    filter_.load(in);
    committed_.load(in);
    smoother_.load(in);
  }

  skipped_ = [&](const Measurement& m) {
    for (Needed* needed : {&again, &newest, &last}) needed->offer(m);
  };
  read_again();
  skipped_ = nullptr;
  for (const Needed* needed : {&again, &newest, &last}) needed->check();

  started_ = true;
  events_ = std::move(events);
  arrival_events_ = std::move(arrival_events);
  for (Measurement& m : newest.found) newest_[m.sensor] = std::move(m);
  if (maps_.empty() && history_.keeps()) {
    history_.begin(std::move(mark));
    go_back(history_.marks().front());
    for (const Measurement& m : again.found) take_in(m);
    for (std::size_t i = 0; i < taken_in_late.size(); ++i) {
      committed_.sensors[i].counters.taken_in_late = taken_in_late[i];
    }
  }
  judge(filter_.stamp());
  if (!last.found.empty()) last_ = {std::move(last.found.front()), fate};
  redoing_ = false;
}

}  // namespace waymark
