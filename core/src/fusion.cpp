// SPDX-License-Identifier: Apache-2.0
#include "waymark/fusion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "fuse_rule.hpp"
#include "standstill.hpp"
#include "start_finder.hpp"
#include "waymark/error.hpp"

namespace waymark {

namespace {

/// A sensor at run time.
struct SensorState {
  SensorSlot slot;
  FuseGate fuse;
  UpdatePolicy policy;
  SensorReport report;
  int rejections_in_a_row = 0;
  bool told_unheard = false;
  bool triggers_map = false;
};

bool goes_on_to_be_fused(const SensorSlot& slot) {
  return slot.fuse.mode != FuseRule::Mode::start && slot.fuse.mode != FuseRule::Mode::none;
}

/// True if an absolute sensor can tell the start (`fused` false), or goes on to be fused (`fused` true).
bool has_absolute(const std::vector<SensorSlot>& sensors, bool fused) {
  return std::any_of(sensors.begin(), sensors.end(), [&](const SensorSlot& s) {
    return s.enabled && s.sensor && s.sensor->is_absolute() && s.fuse.mode != FuseRule::Mode::none &&
           (!fused || goes_on_to_be_fused(s));
  });
}

/// Without maps nothing would stay behind when the map is moved, and without an absolute sensor nothing moves it.
bool needs_georeference(const FusionSettings& settings, const std::vector<SensorSlot>& sensors,
                        const std::vector<MapSlot>& maps) {
  return settings.georeference.enabled && !maps.empty() && has_absolute(sensors, true);
}

/// Sensors in the order of the YAML; then the georeference, if there is one.
std::vector<StateLayout::Owner> block_owners(const FusionSettings& settings, const std::vector<SensorSlot>& sensors,
                                             const std::vector<MapSlot>& maps) {
  std::vector<StateLayout::Owner> owners;
  owners.reserve(sensors.size() + 1);
  for (const SensorSlot& slot : sensors) {
    owners.push_back({slot.name, slot.sensor && slot.enabled ? slot.sensor->block() : StateBlock{}});
  }
  if (needs_georeference(settings, sensors, maps)) {
    owners.push_back({std::string(Georeference::kOwner), Georeference::block(settings.motion, settings.georeference)});
  }
  return owners;
}

std::optional<Georeference> georeference_of(const StateLayout& layout) {
  if (layout.owners().empty() || layout.owners().back().name != Georeference::kOwner) return std::nullopt;
  return Georeference(layout, static_cast<int>(layout.owners().size()) - 1);
}

}  // namespace

class Fusion::Impl {
 public:
  Impl(const FusionSettings& settings, std::vector<SensorSlot> sensors, std::vector<MapSlot> maps, Observer observer)
      : settings_(settings),
        layout_(settings.motion, block_owners(settings, sensors, maps)),
        process_(layout_, settings.process_noise),
        maps_(std::move(maps)),
        filter_(process_, modules(), settings.filter, georeference_of(layout_)),
        queue_(settings.max_latency),
        standstill_(sensors.size(), settings.standstill_after),
        finder_(settings.start, layout_, has_absolute(sensors, false), has_absolute(sensors, true)),
        datum_(settings.datum),
        observer_(std::move(observer)) {
    check(sensors);
    for (std::size_t i = 0; i < sensors.size(); ++i) {
      SensorState state{sensors[i],
                        FuseGate(sensors[i].fuse),
                        {static_cast<int>(i), Gates(sensors[i].gate_probability), sensors[i].weight_exponent, false,
                         sensors[i].sensor && sensors[i].sensor->is_absolute()},
                        {}};
      state.report.name = sensors[i].name;
      state.report.plugin = sensors[i].plugin;
      state.triggers_map = std::any_of(maps_.begin(), maps_.end(),
                                       [&](const MapSlot& m) { return m.inputs.front() == static_cast<int>(i); });
      sensors_.push_back(std::move(state));
    }
    newest_.resize(sensors_.size());
  }

  void add(Measurement measurement) {
    SensorReport& report = sensors_[measurement.sensor].report;
    const double stamp = to_seconds(measurement.stamp.time_since_epoch());
    if (report.measurements++ == 0) report.first_s = stamp;
    report.last_s = std::max(report.last_s, stamp);
    if (!queue_.push(std::move(measurement))) {
      ++report.late;
      return;
    }
    while (auto due = queue_.pop_due()) commit(std::move(*due));
  }

  void finish() {
    while (auto next = queue_.pop()) commit(std::move(*next));
    if (!started_) {
      for (const Measurement& m : buffer_) count(m, Fate::before_start);
      buffer_.clear();
      event(last_stamp_,
            "the filter never started: " + (!start_                      ? finder_.missing()
                                            : settings_.motion_from_maps ? "no map has been given a measurement"
                                                                         : "no motion sensor has said anything"));
    }
  }

  Belief front(Time at) const;
  void show_last(const Observer& observer) const;

  bool started() const { return started_; }
  const ParticleFilter& filter() const { return filter_; }
  const StateLayout& layout() const { return layout_; }
  std::optional<Datum> datum() const { return datum_; }

  RunReport report() const {
    RunReport report;
    for (const SensorState& sensor : sensors_) report.sensors.push_back(sensor.report);
    report.events = events_;
    report.resamplings = filter_.resamplings();
    report.mapping_steps = filter_.mapping_steps();
    return report;
  }

 private:
  class View;

  std::vector<std::shared_ptr<MapModule>> modules() const {
    std::vector<std::shared_ptr<MapModule>> modules;
    modules.reserve(maps_.size());
    for (const MapSlot& map : maps_) modules.push_back(map.module);
    return modules;
  }

  void check(const std::vector<SensorSlot>& sensors) const {
    const auto any = [&](auto property) {
      return std::any_of(sensors.begin(), sensors.end(), [&](const SensorSlot& s) {
        return s.enabled && s.sensor && goes_on_to_be_fused(s) && property(*s.sensor);
      });
    };
    const bool has_motion_sensor = any([](const Sensor& s) { return s.is_motion_source(); });
    const bool has_localizing_map = std::ranges::any_of(maps_, [&](const MapSlot& m) {
      const SensorSlot& trigger = sensors[static_cast<std::size_t>(m.inputs.front())];
      return m.localize && trigger.enabled && goes_on_to_be_fused(trigger);
    });
    if (settings_.motion_from_maps && has_motion_sensor) {
      throw ConfigError("motion.told_by: maps is for a robot without a motion sensor, but one is enabled");
    }
    if (settings_.motion_from_maps && !has_localizing_map) {
      throw ConfigError("motion.told_by: maps needs a map that localises; there is none with an enabled sensor");
    }
    if (!settings_.motion_from_maps && !has_motion_sensor) {
      throw ConfigError(
          "sensors: none of the enabled sensors tells how the robot moves; add one (plugin: odometry, for example), or "
          "with a map that localises set motion.told_by: maps");
    }
    if (settings_.motion == StateLayout::Motion::spatial &&
        !any([](const Sensor& s) { return s.observes_roll_and_pitch(); })) {
      throw ConfigError("motion.kind: spatial needs a sensor that observes roll and pitch; without one use planar");
    }
    check_magnetometers(sensors);
  }

  /// One magnetometer feeds the IMU's own filter or a compass, never both.
  static void check_magnetometers(const std::vector<SensorSlot>& sensors) {
    const SensorSlot* first = nullptr;
    for (const SensorSlot& slot : sensors) {
      if (!slot.enabled || !slot.sensor || !goes_on_to_be_fused(slot) || !slot.sensor->uses_magnetometer()) continue;
      if (first != nullptr) {
        throw ConfigError(fmt::format(
            "sensors.{} and sensors.{} both take their heading from a magnetometer: if it is the same one, leave it to "
            "one of them; if not, set own_magnetometer: true",
            first->name, slot.name));
      }
      first = &slot;
    }
  }

  void event(Time stamp, std::string text) {
    events_.push_back({std::move(text), to_seconds(stamp.time_since_epoch())});
  }
  void failure(Time stamp, std::string_view name, std::string_view why) {
    event(stamp, fmt::format("{}: taken out of service: {}", name, why));
    events_.back().is_failure = true;
  }
  void commit(Measurement&& m);
  void begin(const Start& start);
  std::optional<StartHint> start_hint(const Measurement& m);
  void take_in(const Measurement& m);
  Fate update(SensorState& state, const Measurement& m);
  bool settle_motion(SensorState& state, const Measurement& m);
  void reacquire(SensorState& state, const Update& model, const MixtureOutcome& outcome, Time stamp);
  Fate map(const Measurement& m, Fate fate);
  bool is_companion(std::uint32_t sensor) const;
  void count(const Measurement& m, Fate fate);
  void out_of_service(SensorState& state, Time stamp, std::string_view why);

  FusionSettings settings_;
  StateLayout layout_;
  ProcessModel process_;
  std::vector<MapSlot> maps_;
  ParticleFilter filter_;
  MeasurementQueue queue_;
  Standstill standstill_;
  StartFinder finder_;
  std::optional<Datum> datum_;
  Observer observer_;
  std::vector<SensorState> sensors_;
  std::vector<std::optional<Measurement>> newest_;  // per sensor, for maps with several inputs
  std::vector<Measurement> buffer_;                 // before the start
  std::optional<Start> start_;                      // found, but no motion sensor has spoken yet
  std::vector<Event> events_;
  UpdateList updates_;
  std::optional<std::pair<Measurement, Fate>> last_;
  Time last_stamp_{};
  bool started_ = false;
};

/// The snapshot that sinks see.
class Fusion::Impl::View final : public Snapshot {
 public:
  View(const Impl& host, const Measurement& measurement, Fate fate)
      : host_(host), measurement_(measurement), fate_(fate) {}

  Time stamp() const override { return measurement_.stamp; }
  const Measurement& measurement() const override { return measurement_; }
  Fate fate() const override { return fate_; }
  bool started() const override { return host_.started_; }
  const Belief& belief() const override { return host_.filter_.mixture(); }
  const StateLayout& layout() const override { return host_.layout_; }
  double effective_sample_size() const override { return host_.filter_.effective_sample_size(); }

  std::vector<ParticleView> particles() const override {
    std::vector<ParticleView> views;
    for (const Particle& particle : host_.filter_.particles())
      views.push_back(
          {host_.filter_.T_enu_map(particle) * particle.belief.mean.T_map_base, std::exp(particle.log_weight)});
    return views;
  }

  std::vector<StampedPose> best_path() const override {
    std::vector<StampedPose> path = best().path.poses();
    if (host_.filter_.georeference()) {
      const Pose T_enu_map = host_.filter_.T_enu_map(best());
      for (StampedPose& node : path) node.T_map_base = T_enu_map * node.T_map_base;
    }
    return path;
  }

  std::vector<MapDescription> best_maps() const override {
    std::vector<MapDescription> result;
    for (std::size_t i = 0; i < host_.maps_.size(); ++i) {
      if (!best().maps[i]) continue;
      result.emplace_back();
      result.back().module = host_.maps_[i].name;
      best().maps[i]->describe(result.back());
      if (host_.maps_[i].module) host_.maps_[i].module->describe(result.back().figures);
      if (host_.filter_.georeference()) place_on_earth(result.back());
    }
    return result;
  }

 private:
  /// The map module knows its landmarks in the map; what is shown is where they stand on the Earth, and how well that
  /// is known.
  void place_on_earth(MapDescription& map) const {
    const Georeference& georeference = *host_.filter_.georeference();
    const Pose T_enu_map = host_.filter_.T_enu_map(best());
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
    turn.topLeftCorner<2, 2>() = T_enu_map.q.toRotationMatrix().topLeftCorner<2, 2>();
    for (LandmarkView& landmark : map.landmarks) {
      landmark.P = turn * landmark.P * turn.transpose();
      landmark.P.topLeftCorner<2, 2>() += georeference.point_covariance(best().belief, landmark.p_map);
      landmark.p_map = (T_enu_map * Eigen::Vector3d(landmark.p_map.x(), landmark.p_map.y(), 0.0)).head<2>();
    }
  }

  const Particle& best() const { return host_.filter_.particles()[static_cast<std::size_t>(host_.filter_.best())]; }

  const Impl& host_;
  const Measurement& measurement_;
  Fate fate_;
};

void Fusion::Impl::commit(Measurement&& m) {
  last_stamp_ = m.stamp;
  if (started_) {
    take_in(m);
    return;
  }
  buffer_.push_back(m);
  if (!start_) start_ = finder_.consider(m, start_hint(m));
  if (!start_) return;
  // The clock starts with the first word about motion: until then the twist is anybody's guess, and a second of
  // guessing turns the map.
  const auto first_motion = std::find_if(buffer_.begin(), buffer_.end(), [&](const Measurement& b) {
    const SensorState& state = sensors_[b.sensor];
    const bool tells =
        settings_.motion_from_maps ? state.triggers_map : state.slot.sensor && state.slot.sensor->is_motion_source();
    return b.stamp >= start_->prior.stamp && tells && goes_on_to_be_fused(state.slot);
  });
  if (first_motion == buffer_.end()) return;
  start_->prior.stamp = first_motion->stamp;
  begin(*start_);
}

std::optional<StartHint> Fusion::Impl::start_hint(const Measurement& m) {
  const SensorSlot& slot = sensors_[m.sensor].slot;
  if (!slot.sensor || slot.fuse.mode == FuseRule::Mode::none) return std::nullopt;
  try {
    auto hint = slot.sensor->start_hint(m, datum_ ? &*datum_ : nullptr);
    if (hint && hint->datum && !datum_) {
      datum_ = hint->datum;
      hint = slot.sensor->start_hint(m, &*datum_);
    }
    return hint;
  } catch (const DataError&) {
    return std::nullopt;
  }
}

void Fusion::Impl::begin(const Start& start) {
  filter_.start(start.prior, start.draw);
  started_ = true;
  std::vector<Measurement> waiting;
  waiting.swap(buffer_);
  for (const Measurement& m : waiting) {
    const bool before = m.stamp < start.prior.stamp;
    if (before) sensors_[m.sensor].fuse.fuses(m.stamp);  // its turns and stretches count from the first measurement
    if (start.used && m.sequence == start.used_sequence) {
      count(m, Fate::fused);  // it is in the start pose
    } else if (before) {
      count(m, Fate::before_start);
    } else {
      take_in(m);
    }
  }
}

/// True if a map in service takes this sensor's measurements along with those of its first input.
bool Fusion::Impl::is_companion(std::uint32_t sensor) const {
  return std::ranges::any_of(maps_, [&](const MapSlot& map) {
    return map.module &&
           std::find(map.inputs.begin() + 1, map.inputs.end(), static_cast<int>(sensor)) != map.inputs.end();
  });
}

/// One measurement on the committed side: predict, update, map, show.
void Fusion::Impl::take_in(const Measurement& m) {
  SensorState& state = sensors_[m.sensor];
  if (standstill_.lapses(m.stamp)) filter_.release(settings_.start.velocity_sigma, settings_.start.rate_sigma);
  filter_.predict(m.stamp, standstill_.standing());

  Fate fate = Fate::unheard;
  const bool fuse = state.fuse.fuses(m.stamp);
  if (!fuse) {
    fate = Fate::held_out;
  } else {
    if (state.slot.sensor) fate = update(state, m);
    if (state.triggers_map) fate = map(m, fate);
    newest_[m.sensor] = m;
    if (fate == Fate::unheard && is_companion(m.sensor)) fate = Fate::paired;
  }
  if (maps_.empty()) filter_.record_path();

  if (fate == Fate::unheard && !state.told_unheard) {
    state.told_unheard = true;
    event(m.stamp, fmt::format("{}: no plugin in service listens to this sensor", state.slot.name));
  }
  count(m, fate);
}

void Fusion::Impl::count(const Measurement& m, Fate fate) {
  SensorReport& report = sensors_[m.sensor].report;
  switch (fate) {
    case Fate::fused:
      ++report.fused;
      break;
    case Fate::gated:
      ++report.gated;
      break;
    case Fate::mapped:
    case Fate::paired:
      ++report.mapped;
      break;
    case Fate::held_out:
      ++report.held_out;
      break;
    case Fate::late:
      ++report.late;
      break;
    case Fate::before_start:
      ++report.before_start;
      break;
    case Fate::unusable:
      ++report.unusable;
      break;
    case Fate::unheard:
      ++report.unheard;
      break;
  }
  last_ = {m, fate};
  if (observer_) observer_(View(*this, m, fate));
}

void Fusion::Impl::show_last(const Observer& observer) const {
  if (last_) observer(View(*this, last_->first, last_->second));
}

Fate Fusion::Impl::update(SensorState& state, const Measurement& m) {
  Sensor& sensor = *state.slot.sensor;
  if (!datum_) start_hint(m);  // a geodetic sensor that only now delivers settles the map's origin
  const int owner = state.policy.owner;
  const Belief& mixture = filter_.mixture();
  const Prediction prediction{mixture, layout_, mixture.mean.block.data() + layout_.block_offset(owner),
                              datum_ ? &*datum_ : nullptr, standstill_.standing()};
  updates_.clear();
  try {
    sensor.process(m, prediction, updates_);
    if (settle_motion(state, m)) return Fate::fused;
    Fate fate = Fate::fused;
    for (std::size_t i = 0; i < updates_.size(); ++i) {
      const MixtureOutcome outcome = filter_.update(updates_[i], state.policy);
      if (!outcome.usable) {
        fate = Fate::unusable;
        continue;
      }
      state.report.nis_sum += outcome.nis;
      state.report.nis_dof += static_cast<std::uint64_t>(outcome.innovation.size());
      ++state.report.nis_count;
      sensor.outcome({i, outcome.innovation, outcome.S, outcome.nis, outcome.accepted});
      if (outcome.accepted) {
        state.rejections_in_a_row = 0;
        continue;
      }
      if (fate == Fate::fused) fate = Fate::gated;
      if (state.slot.max_consecutive_rejections > 0 &&
          ++state.rejections_in_a_row >= state.slot.max_consecutive_rejections) {
        reacquire(state, updates_[i], outcome, m.stamp);
      }
    }
    return fate;
  } catch (const DataError& error) {
    if (state.report.unusable == 0)
      event(m.stamp, fmt::format("{}: {} (further ones are only counted)", state.slot.name, error.what()));
    return Fate::unusable;
  } catch (const std::exception& error) {
    out_of_service(state, m.stamp, error.what());
  } catch (...) {
    out_of_service(state, m.stamp, "unknown exception");
  }
  return Fate::unheard;
}

/// Follows what motion sensors say; true if the robot stands, and the zero twist has replaced the update.
bool Fusion::Impl::settle_motion(SensorState& state, const Measurement& m) {
  if (updates_.motion() == UpdateList::Motion::not_said) return false;
  const bool stood = standstill_.standing();
  standstill_.report(m.sensor, m.stamp, updates_.motion() == UpdateList::Motion::moving);
  if (!stood && standstill_.standing()) filter_.stop();
  if (stood && !standstill_.standing()) filter_.release(settings_.start.velocity_sigma, settings_.start.rate_sigma);
  return standstill_.standing() && state.slot.sensor->is_motion_source();
}

/// A sensor that was rejected too often in a row is right and the filter is wrong, or the other way round; a filter
/// that never listens again is the worse of the two.
void Fusion::Impl::reacquire(SensorState& state, const Update& model, const MixtureOutcome& outcome, Time stamp) {
  constexpr double kYawSigma = 0.17;  // 10°: enough for the next fixes to turn the heading
  const double miss = outcome.innovation.norm();
  if (state.slot.sensor->is_absolute()) {
    filter_.inflate_pose(miss * miss, kYawSigma * kYawSigma);
  } else {
    filter_.release(settings_.start.velocity_sigma, settings_.start.rate_sigma);
  }
  UpdatePolicy open = state.policy;
  open.ignore_gate = true;
  filter_.update(model, open);
  event(stamp, fmt::format("{}: {} measurements in a row rejected, the last one by {:.3g}; the belief was widened and "
                           "the sensor re-acquired",
                           state.slot.name, state.rejections_in_a_row, miss));
  state.rejections_in_a_row = 0;
}

Fate Fusion::Impl::map(const Measurement& m, Fate fate) {
  const Belief& mixture = filter_.mixture();
  const MotionWindow motion{mixture.mean.v_base, mixture.mean.w_base};
  std::vector<MappingInput> inputs;
  std::vector<std::shared_ptr<const Observation>> observations;  // keeps them alive
  std::vector<Companion> companions;
  for (std::size_t i = 0; i < maps_.size(); ++i) {
    MapSlot& map = maps_[i];
    if (!map.module || map.inputs.front() != static_cast<int>(m.sensor)) continue;
    companions.clear();
    for (std::size_t k = 1; k < map.inputs.size(); ++k) {
      const auto& newest = newest_[static_cast<std::size_t>(map.inputs[k])];
      const bool fresh = newest && m.stamp - newest->stamp <= map.pair_max_age;
      companions.push_back({sensors_[static_cast<std::size_t>(map.inputs[k])].slot.name, fresh ? &*newest : nullptr});
    }
    try {
      if (auto observation = map.module->extract(m, companions, motion)) {
        inputs.push_back({static_cast<int>(i), observation.get(), map.share, map.localize});
        observations.push_back(std::move(observation));
      }
    } catch (const DataError& error) {
      const SensorReport& report = sensors_[m.sensor].report;
      if (report.unusable == 0)
        event(m.stamp, fmt::format("{}: {} (further ones are only counted)", map.name, error.what()));
      fate = Fate::unusable;
    } catch (const std::exception& error) {
      failure(m.stamp, "map " + map.name, error.what());
      filter_.drop_module(static_cast<int>(i));
      map.module = nullptr;
    }
  }
  if (inputs.empty()) return fate;
  for (const auto& [input, why] : filter_.map(inputs, m.sensor)) {
    MapSlot& map = maps_[static_cast<std::size_t>(inputs[static_cast<std::size_t>(input)].module)];
    failure(m.stamp, "map " + map.name, why);
    map.module = nullptr;
  }
  return Fate::mapped;
}

void Fusion::Impl::out_of_service(SensorState& state, Time stamp, std::string_view why) {
  failure(stamp, state.slot.name, why);
  state.slot.sensor = nullptr;
}

Belief Fusion::Impl::front(Time at) const {
  if (!started_) throw Error("the filter has not started");
  Belief belief = filter_.mixture();
  std::vector<std::unique_ptr<Sensor>> own(sensors_.size());  // what is not committed must not touch the sensors' state
  Linearization model;
  ekf::Innovation innovation;
  UpdateList updates;
  for (const Measurement& m : queue_.waiting()) {
    if (m.stamp > at) break;
    const SensorState& state = sensors_[m.sensor];
    if (!state.slot.sensor || !goes_on_to_be_fused(state.slot)) continue;
    process_.predict(belief, m.stamp, standstill_.standing());
    if (!own[m.sensor]) own[m.sensor] = state.slot.sensor->clone();
    const int owner = state.policy.owner;
    const double* block = belief.mean.block.data() + layout_.block_offset(owner);
    updates.clear();
    try {
      own[m.sensor]->process(m, {belief, layout_, block, datum_ ? &*datum_ : nullptr, standstill_.standing()}, updates);
      for (std::size_t i = 0; i < updates.size(); ++i) {
        updates[i].linearize({belief.mean, block}, model);
        ekf::innovate(belief, layout_, owner, model, innovation);
        if (innovation.finite && innovation.density.squared_mahalanobis <= state.policy.gates[model.rows()])
          ekf::apply(belief, layout_, innovation);
      }
    } catch (const std::exception&) {
      // The committed side meets the same measurement soon and reports it.
    }
  }
  if (at > belief.stamp) process_.predict(belief, at, standstill_.standing());
  return belief;
}

Fusion::Fusion(const FusionSettings& settings, std::vector<SensorSlot> sensors, std::vector<MapSlot> maps,
               Observer observer)
    : impl_(std::make_unique<Impl>(settings, std::move(sensors), std::move(maps), std::move(observer))) {}
Fusion::~Fusion() = default;
void Fusion::add(Measurement measurement) { impl_->add(std::move(measurement)); }
void Fusion::finish() { impl_->finish(); }
bool Fusion::started() const { return impl_->started(); }
void Fusion::show_last(const Observer& observer) const { impl_->show_last(observer); }
Belief Fusion::front(Time at) const { return impl_->front(at); }
RunReport Fusion::report() const { return impl_->report(); }
const ParticleFilter& Fusion::filter() const { return impl_->filter(); }
const StateLayout& Fusion::layout() const { return impl_->layout(); }
std::optional<Datum> Fusion::datum() const { return impl_->datum(); }

}  // namespace waymark
