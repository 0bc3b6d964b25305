// SPDX-License-Identifier: Apache-2.0
// Construction and reports of the host.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "fusion/inspection.hpp"
#include "fusion/parts.hpp"
#include "fusion/setup.hpp"
#include "fusion/snapshot_view.hpp"

namespace waymark {

Fusion::Parts::Parts(const FusionSettings& given, std::vector<SensorSlot> slots, std::vector<MapSlot> map_slots,
                     Observer receiver)
    : settings(given),
      layout(given.motion,
             (fusion::check_parts(given, slots, map_slots), fusion::block_owners(given, slots, map_slots))),
      process_model(layout, given.process_noise),
      intake(given.clock, given.max_latency, slots.size()),
      startup(given.start, process_model, given.standstill_after, fusion::start_sources(slots, map_slots),
              given.motion_from_maps),
      maps(map_slots),
      committed{{process_model, fusion::modules_of(map_slots), fusion::filter_settings(given, slots, map_slots),
                 fusion::georeference_of(layout, slots.size())},
                fusion::make_records(slots, map_slots),
                monitoring::Standstill(slots.size(), given.standstill_after),
                monitoring::HealthMonitor(given.health, {}, given.motion_from_maps),
                estimation::Smoother(process_model)},
      history(map_slots.empty() ? given.history : Duration::zero()),
      datum(fusion::datum_of(given, map_slots)),
      steps(committed, maps, datum, !given.motion_from_maps),
      present(steps, settings),
      observer(std::move(receiver)) {
  // The roles' names point into the records.
  const auto roles = fusion::roles_of(committed.sensors, map_slots);
  committed.health = monitoring::HealthMonitor(given.health, roles, given.motion_from_maps);
}

void Fusion::Parts::reject(const Measurement& m, const std::string& fault) {
  fusion::SensorRecord& sensor = committed.record(m);
  committed.health.mistimed(m.sensor);
  if (sensor.mistimed++ == 0) {
    arrival_events.push_back(
        {fmt::format("{}: {} (further ones are only counted)", sensor.slot.name, fault), m.arrival});
  }
  notify_observer(m, Fate::mistimed);
}

void Fusion::Parts::add_to_smoother(Fate fate) {
  const bool standing = committed.standstill.standing();
  const bool updated = fate == Fate::fused || fate == Fate::gated;
  const bool resets_twist = updated && !standing && updates.twist_reset().has_value();
  committed.smoother.add(committed.filter.mixture(), standing, resets_twist);
}

Fusion::Fusion(const FusionSettings& settings, std::vector<SensorSlot> sensors, std::vector<MapSlot> maps,
               Observer observer)
    : parts_(std::make_unique<Parts>(settings, std::move(sensors), std::move(maps), std::move(observer))) {}
Fusion::~Fusion() = default;

bool Fusion::started() const { return parts_->started; }
std::uint64_t Fusion::arrived() const { return parts_->arrived; }
bool Fusion::has_pose() const { return parts_->has_pose(); }
const StateLayout& Fusion::layout() const { return parts_->layout; }
const Health& Fusion::health() const { return parts_->committed.health.health(); }
std::optional<Datum> Fusion::datum() const { return parts_->datum; }
int Fusion::georeference_states() const {
  return parts_->committed.filter.georeference() ? static_cast<int>(layout().owners().back().block.size()) : 0;
}

const particles::ParticleFilter& fusion::Inspection::filter(const Fusion& host) {
  return host.parts_->committed.filter;
}

void Fusion::visit_last(const Observer& observer) const {
  const Parts& p = *parts_;
  if (p.last)
    observer(fusion::SnapshotView(p.committed, p.maps.maps(), p.started, p.last->first, p.last->second, p.datum));
}

std::vector<Event> Fusion::take_new_events() {
  Parts& p = *parts_;
  std::vector<Event> events;
  p.new_arrival_events.take(p.arrival_events, events);
  p.committed.new_events.take(p.committed.events, events);
  return events;
}

RunReport Fusion::report() const {
  const Parts& p = *parts_;
  RunReport report;
  for (std::size_t i = 0; i < p.committed.sensors.size(); ++i) {
    const fusion::SensorRecord& record = p.committed.sensors[i];
    SensorReport& sensor = report.sensors.emplace_back();
    static_cast<SensorCounters&>(sensor) = record.state.counters;
    sensor.name = record.slot.name;
    sensor.plugin = record.slot.plugin;
    sensor.is_motion_source = record.traits.is_motion_source;
    p.intake.clocks().report(i, sensor);
  }
  report.events = p.arrival_events;
  p.maps.report(p.committed.last_stamp, report.events);
  report.events.insert(report.events.end(), p.committed.events.begin(), p.committed.events.end());
  // The event that the filter never started comes last, whatever its time.
  std::stable_sort(report.events.begin(), report.events.end() - (p.started || report.events.empty() ? 0 : 1),
                   [](const Event& a, const Event& b) { return a.stamp < b.stamp; });
  report.health = p.committed.health.times();
  report.resamplings = p.committed.filter.resamplings();
  report.mapping_steps = p.committed.filter.mapping_steps();
  report.smoothed = p.committed.smoother.smooth();
  return report;
}

}  // namespace waymark
