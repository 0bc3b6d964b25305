// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "live_view.hpp"
#include "python_robot.hpp"

namespace waymark::python {

/// A running robot for Python: its sources are read and its filter works in threads of their own, which need no GIL
/// (but for sensors and maps in Python). What it shows meanwhile is in its view; all else is read from `robot` once it
/// has ended.
class LiveRobot {
 public:
  /// Begins the run. Throws ConfigError if none of the sources is one of a running robot, else as PythonRobot does.
  explicit LiveRobot(RobotOptions options);
  /// Ends the run.
  ~LiveRobot();
  LiveRobot(const LiveRobot&) = delete;
  LiveRobot& operator=(const LiveRobot&) = delete;

  const LiveView& view() const { return *view_; }
  bool is_running() const;
  /// Waits until the run ends: by a command, `until_s`, or the end of all sources. Returns false if it has not within
  /// `timeout_s`. Throws KeyboardInterrupt.
  bool wait(std::optional<double> timeout_s) const;
  /// Ends the run and commits what is buffered; the sinks write their results. Does nothing at its second call.
  void stop();
  std::shared_ptr<PythonRobot> robot() const { return robot_; }

 private:
  void end_thread();

  std::shared_ptr<LiveView> view_ = std::make_shared<LiveView>();
  std::shared_ptr<PythonRobot> robot_;
  mutable std::mutex mutex_;
  mutable std::condition_variable ended_;
  bool has_ended_ = false;
  std::mutex joining_;
  std::thread thread_;  // last: it uses all others
};

}  // namespace waymark::python
