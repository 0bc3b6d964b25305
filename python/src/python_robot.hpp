// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "fed_source.hpp"
#include "rows.hpp"
#include "waymark/host/session.hpp"

namespace waymark::python {

/// What Python keeps of one snapshot: all that is cheap. Particles and maps are read from the robot.
struct StepRecord {
  Time stamp{};
  Time measurement_stamp{};
  Time arrival{};
  std::uint64_t sequence = 0;
  std::uint32_t sensor = 0;
  Fate fate = Fate::ignored;
  bool started = false;
  Belief belief;                       ///< valid if `started`
  Eigen::Matrix3d pose_covariance{};   ///< the same
  double effective_sample_size = 0.0;  ///< the same
  Health::State health = Health::State::ok;
  std::string health_reason;
  std::optional<Datum> datum;
};

/// Of a snapshot, which is valid during the observer's call only.
StepRecord record_of(const Snapshot& snapshot);

class LiveView;

/// How a robot is built.
struct RobotOptions {
  std::filesystem::path config;  ///< a file: a YAML, or a flight record; or
  std::string yaml;              ///< its text
  std::vector<std::string> overrides;
  std::optional<std::filesystem::path> out;  ///< nothing: no sink writes
  std::string name;
  std::optional<double> until_s;
  std::optional<bool> is_fed;  ///< nothing: if the YAML has no source
  bool records = true;
  bool allows_outside = false;
  std::vector<std::filesystem::path> plugin_folders;
  std::shared_ptr<LiveView> live_view = nullptr;  ///< of a running robot; null: its sources must be logs
};

/// A robot with one run of it, for Python. One thread at a time; the GIL is released while the filter works.
class PythonRobot {
 public:
  explicit PythonRobot(RobotOptions options);

  /// The next snapshot; nothing at the end of what there is to read.
  std::optional<StepRecord> step();
  /// Reads to the end, or until Ctrl-C.
  void play();
  /// Adds a block of measurements of one sensor. Returns their number.
  std::size_t feed(const std::string& sensor, const pybind11::object& stamps, const pybind11::object& arrivals,
                   const std::string& payload, const pybind11::dict& columns);
  /// Commits what is buffered and ends the sinks. Does nothing at its second call.
  void finish();
  /// The same, but what is buffered is not committed: the checkpoint has the state, and `resume` goes on from it.
  void suspend(const std::filesystem::path& checkpoint);
  /// Goes on from a checkpoint; before anything was read. A robot that is fed has been fed the same measurements again.
  void resume(const std::filesystem::path& checkpoint);
  /// Serves a running robot until `stop_live`, which any thread may call, also before. Called without the GIL.
  void play_live();
  void stop_live() { stop_ = true; }
  bool is_finished() const { return result_.has_value(); }
  bool is_fed() const { return fed_ != nullptr; }
  std::uint64_t waiting() const;  ///< measurements that were fed and not read yet

  StepRecord front(std::int64_t at_ns) const;
  std::vector<std::string> sensor_names() const;
  std::vector<std::string> map_names() const;
  std::vector<std::string> state_names() const;
  bool started() const;
  std::string config() const { return session_->robot().yaml.effective(); }

  pybind11::object trajectory() const;
  pybind11::object particles() const;
  pybind11::object path() const;
  pybind11::object reference() const;
  pybind11::object smoothed() const;
  pybind11::object landmarks(const std::string& map) const;
  pybind11::object sightings(const std::string& map) const;
  pybind11::object grid(const std::string& map, bool is_mixture) const;
  pybind11::dict figures(const std::string& map) const;
  pybind11::dict files(const std::string& map) const;
  pybind11::dict report() const;

 private:
  /// The robot is in use by one call; another one, from another thread or from within, is refused.
  class Turn {
   public:
    explicit Turn(const PythonRobot& robot) : robot_(robot) {
      if (robot_.is_used_.exchange(true)) throw std::runtime_error("the robot is in use by another call");
    }
    ~Turn() { robot_.is_used_ = false; }
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;

   private:
    const PythonRobot& robot_;
  };

  RunReport run_report() const;
  void observe(const Snapshot& snapshot);
  MapDescription describe(const std::string& map, MapDetail detail) const;
  void resume_live(const std::filesystem::path& out);
  void read_on();
  template <class End>
  void end_by(const End& end);
  void raise_interrupt();

  std::vector<TrajectoryRow> rows_;
  std::deque<StepRecord> steps_;  // committed together, not yet returned
  bool records_ = true;
  bool is_stepping_ = false;
  bool is_interrupted_ = false;
  std::shared_ptr<LiveView> live_view_;
  std::chrono::steady_clock::time_point signals_checked_{};
  std::atomic<bool> stop_{false};
  mutable std::atomic<bool> is_used_{false};
  std::shared_ptr<FedSource> fed_;
  std::unique_ptr<host::Session> session_;
  std::optional<host::SessionResult> result_;
};

}  // namespace waymark::python
