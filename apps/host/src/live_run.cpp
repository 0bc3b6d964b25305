// SPDX-License-Identifier: Apache-2.0
#include "live_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <ctime>
#include <utility>

#include "waymark/base/error.hpp"

namespace waymark::host {
namespace {

double process_cpu_s() {
  timespec used{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &used);
  return static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec);
}

bool is_motion_source(const SensorSlot& slot) { return slot.sensor && slot.sensor->traits().is_motion_source; }

/// Those that the filter takes, and a little more: `delay_s` may be tuned.
UsableOffsets usable_offsets(const SensorSlot& slot, const ClockSettings& clock) {
  constexpr Duration kMargin = std::chrono::seconds(1);
  return {slot.delay - clock.max_jump, slot.delay + clock.max_ahead + kMargin};
}

/// Sensors without a plugin of their own feed maps only. Those that no map localises with are thinned first.
std::vector<LiveInput::Policy> policies_of(const Robot& robot) {
  const auto localises = [&](int sensor) {
    return std::ranges::any_of(robot.maps, [&](const MapSlot& map) {
      return map.localize && std::ranges::find(map.inputs, sensor) != map.inputs.end();
    });
  };
  std::vector<LiveInput::Policy> policies;
  for (const int sensor : robot.sensor_of_channel) {
    LiveInput::Policy& policy = policies.emplace_back();
    if (sensor < 0) continue;
    const SensorSlot& slot = robot.sensors[static_cast<std::size_t>(sensor)];
    policy.offsets = usable_offsets(slot, robot.settings.clock);
    if (slot.plugin.empty()) policy.thin_after = robot.live_settings.overload_after * (localises(sensor) ? 2 : 1);
    policy.may_drop = std::ranges::find(robot.live_settings.may_drop, slot.name) != robot.live_settings.may_drop.end();
  }
  return policies;
}

}  // namespace

LiveRun::LiveRun(std::shared_ptr<LiveInput> input, std::shared_ptr<const LiveClock> clock, const Robot& robot,
                 Results& results, const std::atomic<bool>* stop, std::function<void()> on_wait)
    : input_(std::move(input)),
      clock_(std::move(clock)),
      robot_(robot),
      results_(results),
      latency_(robot.sensors.size()),
      began_(std::chrono::steady_clock::now()),
      last_checkpoint_(began_),
      cpu_at_begin_s_(process_cpu_s()) {
  std::vector<bool> prompts;
  for (const SensorSlot& slot : robot.sensors) {
    prompts.push_back(is_motion_source(slot));
    has_plugin_.push_back(slot.sensor != nullptr);
  }
  front_ = std::make_unique<FrontOutput>([this](const Belief& belief) { results_.front(belief); },
                                         robot.live_settings.front_hz, std::move(prompts), *clock_);
  if (!robot.live_settings.control.empty()) {
    control_ = std::make_unique<ControlSocket>(robot.live_settings.control,
                                               [this](std::string text) { return input_->command(std::move(text)); });
  }
  LiveInput::Options options{.capacity = robot.live_settings.queue, .stop = stop};
  options.on_arrival = [this](const Measurement& m) { arrived(m); };
  options.on_wait = [this, on_wait = std::move(on_wait)] {
    service_.alive();
    look_for_silence();
    on_wait();
  };
  input_->configure(std::move(options), policies_of(robot));
}

LiveRun::~LiveRun() { end(); }

/// In a thread that reads a source, while the filter's may change settings of the robot.
void LiveRun::arrived(const Measurement& measurement) {
  Measurement of_sensor = measurement;
  if (!robot_.assign(of_sensor)) return;
  if (has_plugin_[of_sensor.sensor]) front_->arrived(of_sensor);
}

void LiveRun::processed(const Snapshot& snapshot) {
  const Measurement& m = snapshot.measurement();
  latency_[m.sensor].add(to_seconds(clock_->now() - m.arrival));
  if (snapshot.started()) service_.ready();
}

Duration LiveRun::silence() const {
  if (!last_added_) return Duration::zero();
  const Duration since = clock_->now() - *last_added_;
  return since > kSilence ? since : Duration::zero();
}

void LiveRun::look_for_silence() {
  if (silence() == Duration::zero() || std::exchange(is_silent_, true)) return;
  note(fmt::format("nothing has arrived for {:.1f} s", to_seconds(silence())));
}

std::map<std::uint32_t, std::size_t> LiveRun::added(const Fusion& fusion) {
  if (std::exchange(is_silent_, false))
    note(fmt::format("measurements arrive again after {:.1f} s", to_seconds(silence())));
  last_added_ = clock_->now();
  std::map<std::uint32_t, std::size_t> dropped_of;
  for (Measurement& dropped : input_->take_dropped()) {
    if (!robot_.assign(dropped)) continue;
    results_.dropped(dropped);
    ++dropped_of[dropped.sensor];
  }
  if (auto front = fusion.front()) front_->rebase(std::move(front));
  service_.alive();
  return dropped_of;
}

std::vector<LiveRun::SensorGap> LiveRun::take_gaps() {
  std::vector<SensorGap> gaps;
  for (const LiveInput::ChannelGap& one : input_->take_gaps()) {
    const int sensor = robot_.sensor_of_channel[one.channel];
    if (sensor >= 0) gaps.push_back({static_cast<std::uint32_t>(sensor), one.gap});
  }
  return gaps;
}

std::vector<Measurement> LiveRun::waiting_measurements() const {
  std::vector<Measurement> of_channels = input_->waiting_measurements();
  std::erase_if(of_channels, [this](Measurement& m) { return !robot_.assign(m); });
  return of_channels;
}

bool LiveRun::checkpoint_is_due() {
  const auto now = std::chrono::steady_clock::now();
  if (robot_.live_settings.checkpoint.empty() || now - last_checkpoint_ < robot_.live_settings.checkpoint_every)
    return false;
  last_checkpoint_ = now;
  return true;
}

void LiveRun::reply(std::uint64_t command, std::string answer) {
  if (control_) control_->reply(command, std::move(answer));
}

void LiveRun::note(std::string text) { events_.push_back({std::move(text), clock_->now(), false}); }

std::vector<Event> LiveRun::take_events() {
  for (std::string& text : input_->take_events()) note(std::move(text));
  for (std::string& text : results_.take_events()) note(std::move(text));
  return std::exchange(events_, {});
}

void LiveRun::end() {
  if (final_) return;
  service_.stopping();
  input_->stop();
  control_ = nullptr;
  final_ = report();
  front_ = nullptr;
}

LiveReport LiveRun::report() const {
  if (final_) return *final_;
  LiveReport report;
  const std::vector<LiveInput::Counts> counts = input_->counts();
  for (std::size_t channel = 0; channel < counts.size(); ++channel) {
    const int sensor = robot_.sensor_of_channel[channel];
    if (sensor < 0) continue;
    const Latency& latency = latency_[static_cast<std::size_t>(sensor)];
    LiveReport::Stream& stream = report.streams.emplace_back();
    stream.sensor = robot_.sensors[static_cast<std::size_t>(sensor)].name;
    stream.received = counts[channel].received;
    stream.dropped = counts[channel].dropped;
    stream.missing = counts[channel].gaps.missing();
    stream.waits = counts[channel].waits;
    stream.clock_offset_s = counts[channel].clock.offset_s() + to_seconds(counts[channel].steps.total());
    stream.clock_drift = counts[channel].clock.drift();
    stream.latency_s = {latency.quantile(0.5), latency.quantile(0.99), latency.max()};
  }
  const Latency front = front_->latency();
  report.front_latency_s = {front.quantile(0.5), front.quantile(0.99), front.max()};
  report.duration_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count();
  report.cpu_share = (process_cpu_s() - cpu_at_begin_s_) / report.duration_s;
  return report;
}

}  // namespace waymark::host
