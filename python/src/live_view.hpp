// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <chrono>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "python_robot.hpp"
#include "waymark/interface/sink.hpp"

namespace waymark::python {

/// What can be read of a running robot while its filter works: a sink, which is given the pose now, the belief after
/// each measurement, and the session's events. Everything is kept as a copy; the readers are other threads.
class LiveView final : public Sink {
 public:
  struct HealthNow {
    Health::State state = Health::State::ok;
    std::string reason;
  };

  void start(const RunInfo&) override {}
  void arrived(const Measurement&) override;
  void write(const Snapshot& snapshot) override;
  void front(const Belief& belief) override;
  void finish(const Snapshot*, const RunReport&) override {}
  void note(const Event& event);

  /// The belief at the time of its `stamp`, the present when it was made; nothing before the filter starts.
  std::optional<StepRecord> front() const;
  /// After the last processed measurement; nothing before the first one.
  std::optional<StepRecord> last() const;
  /// That of the filter; lost while nothing arrives.
  HealthNow health() const;
  /// Those so far: of many, the last ones.
  std::vector<Event> events() const;

 private:
  mutable std::mutex mutex_;
  std::optional<StepRecord> front_;
  std::optional<StepRecord> last_;
  std::array<int, 3> pose_indices_{};  // of the state, in the covariance
  std::optional<std::chrono::steady_clock::time_point> last_arrival_;
  std::deque<Event> events_;
};

}  // namespace waymark::python
