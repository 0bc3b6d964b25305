// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "latency.hpp"
#include "live_clock.hpp"
#include "waymark/host/front.hpp"

namespace waymark::host {

/// The pose now, in a thread of its own: the filter's last belief, updated with what has arrived since and predicted to
/// the present. It never waits for a mapping step.
class FrontOutput {
 public:
  /// `publish` is called at `rate_hz`, and after each measurement for which `prompts` of its sensor is true. `clock`
  /// must outlive the object.
  FrontOutput(std::function<void(const Belief&)> publish, double rate_hz, std::vector<bool> prompts,
              const LiveClock& clock);
  ~FrontOutput();
  FrontOutput(const FrontOutput&) = delete;
  FrontOutput& operator=(const FrontOutput&) = delete;

  /// Adds what arrived, in order of arrival; `Measurement::sensor` is an index into the robot's sensors.
  void arrived(const Measurement& measurement);
  /// Begins again at what the filter has committed. The front's filter must live until it is replaced, or longer than
  /// this object.
  void rebase(std::unique_ptr<Front> front);
  /// The same with another filter: on return nothing of the one before is used any more.
  void replace(std::unique_ptr<Front> front);
  /// Time from the arrival of a prompting measurement to the end of the `publish` that contains it.
  Latency latency() const;

 private:
  void run();
  void follow(std::unique_ptr<Front> base);
  void report_following();
  void advance(const Measurement& measurement);

  std::function<void(const Belief&)> publish_;
  Duration period_;
  std::vector<bool> prompts_;
  const LiveClock& clock_;

  // Of the thread alone.
  std::unique_ptr<Front> front_;
  std::vector<Measurement> ahead_;  // of what the filter has committed
  Time newest_stamp_{};
  Time newest_arrival_{};

  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::vector<Measurement> incoming_;
  std::unique_ptr<Front> base_;
  std::condition_variable followed_;
  bool must_follow_ = false;  // the thread has not begun at `base_` yet, and somebody waits for that
  bool prompted_ = false;
  bool stopped_ = false;
  Latency latency_;
  std::thread thread_;  // last: it uses all others
};

}  // namespace waymark::host
