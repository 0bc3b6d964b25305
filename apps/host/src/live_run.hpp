// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "control_socket.hpp"
#include "front_output.hpp"
#include "latency.hpp"
#include "live_input.hpp"
#include "service_notifier.hpp"
#include "waymark/host/results.hpp"
#include "waymark/host/robot.hpp"

namespace waymark::host {

/// A running robot's share of a session: what lies around the filter's thread. Threads read the sources, publish the
/// pose now, and take commands.
class LiveRun {
 public:
  /// `input` is the robot's source. `on_wait`: called by the filter's thread now and then while nothing arrives.
  /// `robot`, `results` and `stop` must outlive the object. Throws Error if the control socket cannot be made.
  LiveRun(std::shared_ptr<LiveInput> input, std::shared_ptr<const LiveClock> clock, const Robot& robot,
          Results& results, const std::atomic<bool>* stop, std::function<void()> on_wait);
  ~LiveRun();

  /// Called by the filter's thread after each processed measurement.
  void processed(const Snapshot& snapshot);
  /// Called by the filter's thread after each measurement that it was given. Returns how many of each sensor's
  /// measurements were dropped since the last call; sensors without any are left out.
  std::map<std::uint32_t, std::size_t> added(const Fusion& fusion);
  /// Measurements of a sensor that did not arrive.
  struct SensorGap {
    std::uint32_t sensor = 0;
    Gap gap;
  };
  /// The gaps in sensors' stamps that were found since the last call.
  std::vector<SensorGap> take_gaps();
  /// The filter goes on in another host; nothing of the one before is used any more on return.
  void replaced(const Fusion& fusion) { front_->replace(fusion.front()); }
  /// Where the numbers of measurements go on, for a checkpoint and after it.
  std::uint64_t next_sequence() const { return input_->next_sequence(); }
  void number_from(std::uint64_t sequence) { input_->number_from(sequence); }
  /// Copies of the measurements that wait for the filter, by sensor.
  std::vector<Measurement> waiting_measurements() const;
  /// True once each `live.checkpoint.every_s`.
  bool checkpoint_is_due();
  /// Answers a command.
  void reply(std::uint64_t command, std::string answer);
  /// Events since the last call: of the sources, the queue and the sinks.
  std::vector<Event> take_events();
  /// Adds an event of the session.
  void note(std::string text);
  /// Ends the threads. Events and counts remain.
  void end();
  /// Time since the last measurement was given to the filter, if it is long enough to be a fault; else zero. The
  /// filter's own health is of the time of measurements, and stands still with them.
  Duration silence() const;
  /// The statistics so far.
  LiveReport report() const;

 private:
  void arrived(const Measurement& measurement);
  void look_for_silence();

  std::shared_ptr<LiveInput> input_;
  std::shared_ptr<const LiveClock> clock_;
  const Robot& robot_;
  Results& results_;
  std::vector<bool> has_plugin_;  // of each sensor: the pose now uses it
  std::vector<Latency> latency_;  // from arrival to pose, by sensor
  std::vector<Event> events_;
  std::optional<Time> last_added_;
  bool is_silent_ = false;  // reported already
  ServiceNotifier service_;
  std::chrono::steady_clock::time_point began_;
  std::chrono::steady_clock::time_point last_checkpoint_;
  double cpu_at_begin_s_;
  std::unique_ptr<FrontOutput> front_;
  std::unique_ptr<ControlSocket> control_;
  std::optional<LiveReport> final_;
};

}  // namespace waymark::host
