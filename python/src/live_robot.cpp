// SPDX-License-Identifier: Apache-2.0
#include "live_robot.hpp"

#include <algorithm>
#include <chrono>
#include <exception>
#include <utility>

namespace py = pybind11;

namespace waymark::python {
namespace {

/// How often a thread that waits looks for Ctrl-C.
constexpr std::chrono::milliseconds kLookEvery{50};

}  // namespace

LiveRobot::LiveRobot(RobotOptions options) {
  options.live_view = view_;
  robot_ = std::make_shared<PythonRobot>(std::move(options));
  thread_ = std::thread([this] {
    robot_->play_live();
    const std::lock_guard lock(mutex_);
    has_ended_ = true;
    ended_.notify_all();
  });
}

LiveRobot::~LiveRobot() {
  try {
    stop();
  } catch (const std::exception&) {
    // Of a run that nobody asked for the end of, nobody takes the error either.
  }
}

void LiveRobot::end_thread() {
  robot_->stop_live();
  const std::lock_guard one_of_several(joining_);
  if (thread_.joinable()) thread_.join();
}

bool LiveRobot::is_running() const {
  const std::lock_guard lock(mutex_);
  return !has_ended_;
}

bool LiveRobot::wait(std::optional<double> timeout_s) const {
  const auto begin = std::chrono::steady_clock::now();
  while (true) {
    {
      const py::gil_scoped_release released;
      const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - begin;
      const std::chrono::duration<double> left(timeout_s.value_or(1e9) - passed.count());
      std::unique_lock lock(mutex_);
      ended_.wait_for(lock, std::min<std::chrono::duration<double>>(left, kLookEvery), [this] { return has_ended_; });
      if (has_ended_) return true;
      if (left <= kLookEvery) return false;
    }
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  }
}

void LiveRobot::stop() {
  {
    const py::gil_scoped_release released;
    end_thread();
  }
  robot_->finish();
}

}  // namespace waymark::python
