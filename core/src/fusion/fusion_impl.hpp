// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "estimation/smoother.hpp"
#include "fusion/committed.hpp"
#include "fusion/history.hpp"
#include "fusion/measurement_queue.hpp"
#include "fusion/start_finder.hpp"
#include "monitoring/clock_monitor.hpp"
#include "particles/particle_filter.hpp"
#include "waymark/host/fusion.hpp"

namespace waymark {

using namespace fusion;  // NOLINT(google-build-using-namespace)

/// What the YAML settles of a sensor, as the host needs it while running.
struct SensorPart {
  SensorSlot slot;
  particles::UpdatePolicy policy;
  bool triggers_map = false;
  bool told_late = false;
  std::uint64_t mistimed = 0;
};

/// False for a sensor that is only there to find the start, or to be scored against.
bool goes_on_to_be_fused(const SensorSlot& slot);
/// True if an absolute sensor can tell the start (`fused` false), or goes on to be fused (`fused` true).
bool has_absolute(const std::vector<SensorSlot>& sensors, bool fused);
/// Who appends states: the sensors in the order of the YAML; then the georeference, if there is one.
std::vector<StateLayout::Owner> block_owners(const FusionSettings& settings, const std::vector<SensorSlot>& sensors,
                                             const std::vector<MapSlot>& maps);
std::optional<estimation::Georeference> georeference_of(const StateLayout& layout, std::size_t sensors);
/// Throws ConfigError if the parts do not fit together.
void check_parts(const FusionSettings& settings, const std::vector<SensorSlot>& sensors,
                 const std::vector<MapSlot>& maps);

class Fusion::Impl {
 public:
  Impl(const FusionSettings& settings, std::vector<SensorSlot> sensors, std::vector<MapSlot> maps, Observer observer);

  void add(Measurement m);
  void finish();
  Belief front(Time at) const;
  void show_last(const Observer& observer) const;
  RunReport report() const;
  void save(OutArchive& out) const;
  void resume(InArchive& in, const Next& next);

  bool started() const { return started_; }
  const particles::ParticleFilter& filter() const { return filter_; }
  const StateLayout& layout() const { return layout_; }
  const Health& health() const { return committed_.health.health(); }
  std::optional<Datum> datum() const { return datum_; }

 private:
  // The way of a measurement: clock → queue → commit → take in → update, map → count. (fusion.cpp)
  void step(Measurement&& m, bool late);
  void commit(const Measurement& m);
  void before_start(const Measurement& m);
  std::optional<StartHint> start_hint(const Measurement& m);
  void begin(const Start& start);
  Fate take_in(const Measurement& m);
  void count(const Measurement& m, Fate fate);
  void show(const Measurement& m, Fate fate);
  void judge(Time now);

  // What one measurement does to the filter. (fusion_updates.cpp)
  Fate fuse(const Measurement& m, bool late);
  void update(const Measurement& m, bool late, monitoring::Heard& heard);
  void apply(const Measurement& m, std::size_t index, bool late, monitoring::Heard& heard);
  bool settle_motion(const Measurement& m);
  void watch_for_bias(const Measurement& m, const particles::MixtureOutcome& outcome, monitoring::Heard& heard);
  void reacquire(const Measurement& m, std::size_t index, const particles::MixtureOutcome& outcome);
  void map(const Measurement& m, bool late, monitoring::Heard& heard);
  void map_out_of_service(std::size_t map, Time stamp, std::string_view why);
  bool is_companion(std::uint32_t sensor) const;
  void out_of_service(const Measurement& m, std::string_view why);

  // Late data. (fusion_late.cpp)
  void late(const Measurement& m);
  Fate rewind(const Measurement& m);
  Fate weigh(const Measurement& m);
  void go_back(const Mark& mark);
  void mark_if_due();

  // Checkpoints. (fusion_checkpoint.cpp)
  void save_modules(OutArchive& out) const;
  void load_modules(InArchive& in);
  struct Needed;

  void event(Time stamp, std::string text);
  void failure(Time stamp, std::string_view name, std::string_view why);
  SensorState& state_of(const Measurement& m) { return committed_.sensors[m.sensor]; }

  FusionSettings settings_;
  StateLayout layout_;
  estimation::ProcessModel process_;
  std::vector<SensorPart> parts_;
  std::vector<MapSlot> maps_;
  particles::ParticleFilter filter_;
  monitoring::ClockMonitor clocks_;
  MeasurementQueue queue_;
  Committed committed_;
  History history_;
  estimation::Smoother smoother_;
  StartFinder finder_;
  std::optional<Datum> datum_;
  Observer observer_;
  std::vector<std::optional<Measurement>> newest_;  // per sensor, for maps with several inputs
  std::vector<std::uint64_t> unusable_to_;          // per map, measurements that it could make nothing of
  std::vector<Measurement> buffer_;                 // before the start
  std::optional<Start> start_;                      // found, but no motion sensor has spoken yet
  std::vector<Event> events_;
  std::vector<Event> arrival_events_;  // of clocks: these do not go back with the filter
  UpdateList updates_;
  std::vector<Measurement> again_;  // scratch of rewind
  std::optional<std::pair<Measurement, Fate>> last_;
  std::uint64_t arrived_ = 0;
  std::uint64_t steps_ = 0;  // measurements taken in, late ones included, in the order of their coming
  std::uint64_t skip_ = 0;   // steps that a checkpoint has done already
  std::function<void(const Measurement&)> skipped_;  // is shown their measurements
  bool started_ = false;
  bool redoing_ = false;  // what is taken in was taken in before: nobody is shown
};

}  // namespace waymark
