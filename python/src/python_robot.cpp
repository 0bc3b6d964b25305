// SPDX-License-Identifier: Apache-2.0
#include "python_robot.hpp"

#include <pybind11/stl.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "live_view.hpp"
#include "measurement_block.hpp"
#include "waymark/base/error.hpp"
#include "waymark/host/flight_record.hpp"

namespace py = pybind11;

namespace waymark::python {
namespace {

/// How often a run looks for Ctrl-C.
constexpr std::chrono::milliseconds kSignalsEvery{100};

bool was_taken_in(Fate fate) {
  return fate == Fate::fused || fate == Fate::gated || fate == Fate::mapped || fate == Fate::skipped ||
         fate == Fate::held_out;
}

TrajectoryRow row_of(const Snapshot& snapshot) {
  TrajectoryRow row{};
  const Belief& belief = snapshot.belief();
  row.stamp_ns = nanoseconds(snapshot.stamp());
  set_pose(row, belief.mean.T_map_base);
  set_matrix(row.covariance, pose_covariance(belief, snapshot.layout()));
  for (int i = 0; i < 3; ++i) {
    row.velocity[i] = belief.mean.v_base(i);
    row.angular_rate[i] = belief.mean.w_base(i);
  }
  row.effective_sample_size = snapshot.effective_sample_size();
  row.sensor = static_cast<std::int32_t>(snapshot.measurement().sensor);
  row.fate = static_cast<std::int32_t>(snapshot.fate());
  return row;
}

/// With the folders of the Python package before that of the running program, which is the interpreter.
PluginLoader loader_of(const Config& yaml, const std::vector<std::filesystem::path>& more) {
  std::vector<std::filesystem::path> folders = host::plugin_loader(yaml).folders();
  folders.insert(folders.end() - 1, more.begin(), more.end());
  return PluginLoader(std::move(folders));
}

host::RecordedRun read_config(const RobotOptions& options) {
  if (options.config.empty()) return {Config::parse(options.yaml, "yaml", options.overrides), options.name};
  host::RecordedRun read = host::is_flight_record(options.config)
                               ? host::recorded_run(options.config, options.overrides)
                               : host::RecordedRun{Config::load(options.config, options.overrides), {}};
  if (!options.name.empty()) read.name = options.name;
  return read;
}

}  // namespace

StepRecord record_of(const Snapshot& snapshot) {
  StepRecord record;
  const Measurement& measurement = snapshot.measurement();
  record.measurement_stamp = measurement.stamp;
  record.arrival = measurement.arrival;
  record.sequence = measurement.sequence;
  record.sensor = measurement.sensor;
  record.fate = snapshot.fate();
  record.started = snapshot.started();
  record.health = snapshot.health().state;
  record.health_reason = snapshot.health().reason;
  if (!record.started) return record;
  record.stamp = snapshot.stamp();
  record.belief = snapshot.belief();
  record.pose_covariance = pose_covariance(record.belief, snapshot.layout());
  record.effective_sample_size = snapshot.effective_sample_size();
  record.datum = snapshot.datum();
  return record;
}

PythonRobot::PythonRobot(RobotOptions options) : records_(options.records), live_view_(options.live_view) {
  const py::gil_scoped_release released;
  const auto [yaml, name] = read_config(options);
  if (options.allows_outside) yaml.permit_outside();
  const PluginLoader loader = loader_of(yaml, options.plugin_folders);
  const bool is_fed = options.is_fed.value_or(!yaml.has("source") && !yaml.has("sources"));
  host::Robot robot = is_fed ? host::Robot::live(yaml, loader) : host::Robot::load(yaml, loader);
  if (is_fed && live_view_) throw ConfigError(yaml.place() + ": has no source: feed it as a waymark.Robot");
  if (is_fed) {
    std::vector<std::string> names;
    names.reserve(robot.sensors.size());
    for (const SensorSlot& slot : robot.sensors) {
      robot.sensor_of_channel.push_back(slot.enabled ? static_cast<int>(names.size()) : -1);
      names.push_back(slot.name);
    }
    fed_ = std::make_shared<FedSource>(std::move(names));
    robot.source = fed_;
  } else if (robot.source->is_live() && !live_view_) {
    throw ConfigError(yaml.place() + ": its source is of a running robot: run it with waymark.Live");
  } else if (live_view_ && !robot.source->is_live()) {
    throw ConfigError(yaml.place() +
                      ": its source is a log: run it with waymark.run, or as if it ran now with live.real_time: true");
  }
  host::SessionOptions session{.name = name, .until_s = options.until_s, .stop = &stop_};
  if (options.out) {
    std::filesystem::create_directories(*options.out);
    session.out = *options.out;
  } else {
    robot.sinks.clear();
    robot.report = nullptr;
    robot.live_settings.checkpoint.clear();
  }
  session.observer = [this](const Snapshot& snapshot, double) { observe(snapshot); };
  if (live_view_) {
    robot.sinks.push_back({"python", live_view_});
    session.on_event = [this](const Event& event) { live_view_->note(event); };
  }
  session_ = std::make_unique<host::Session>(std::move(robot), std::move(session));
  if (live_view_) resume_live(options.out.value_or(std::filesystem::path()));
}

void PythonRobot::resume_live(const std::filesystem::path& out) {
  const host::LiveSettings& live = session_->robot().live_settings;
  if (!live.resumes || live.checkpoint.empty()) return;
  const std::string problem = session_->resume_if_possible(out / live.checkpoint);
  const Time now(std::chrono::duration_cast<Duration>(std::chrono::system_clock::now().time_since_epoch()));
  if (!problem.empty()) live_view_->note({"begins anew: " + problem, now, false});
}

void PythonRobot::observe(const Snapshot& snapshot) {
  if (records_ && snapshot.started() && was_taken_in(snapshot.fate())) rows_.push_back(row_of(snapshot));
  if (is_stepping_) {
    steps_.push_back(record_of(snapshot));
    stop_ = true;
  }
  if (live_view_) return;  // signals are the main thread's
  const auto now = std::chrono::steady_clock::now();
  if (now - signals_checked_ < kSignalsEvery) return;
  signals_checked_ = now;
  const py::gil_scoped_acquire held;
  if (PyErr_CheckSignals() == 0) return;
  PyErr_Clear();
  is_interrupted_ = true;
  stop_ = true;
}

void PythonRobot::raise_interrupt() {
  if (!std::exchange(is_interrupted_, false)) return;
  PyErr_SetNone(PyExc_KeyboardInterrupt);
  throw py::error_already_set();
}

void PythonRobot::read_on() {
  const py::gil_scoped_release released;
  stop_ = false;
  session_->play();
}

std::optional<StepRecord> PythonRobot::step() {
  const Turn turn(*this);
  if (steps_.empty() && !result_) {
    is_stepping_ = true;
    read_on();
    is_stepping_ = false;
    raise_interrupt();
  }
  if (steps_.empty()) return std::nullopt;
  StepRecord record = std::move(steps_.front());
  steps_.pop_front();
  return record;
}

void PythonRobot::play() {
  const Turn turn(*this);
  if (result_) return;
  steps_.clear();
  read_on();
  raise_interrupt();
}

void PythonRobot::play_live() {
  const Turn turn(*this);
  session_->play();
}

template <class End>
void PythonRobot::end_by(const End& end) {
  const Turn turn(*this);
  if (result_) return;
  {
    const py::gil_scoped_release released;
    stop_ = false;  // a step that ended is no interruption
    is_stepping_ = true;
    result_ = end();
    is_stepping_ = false;
    stop_ = false;
  }
  is_interrupted_ = false;
}

void PythonRobot::finish() {
  end_by([this] { return session_->finish(); });
}

void PythonRobot::suspend(const std::filesystem::path& checkpoint) {
  end_by([&] { return session_->suspend(checkpoint); });
}

void PythonRobot::resume(const std::filesystem::path& checkpoint) {
  const Turn turn(*this);
  const py::gil_scoped_release released;
  session_->resume(checkpoint);
}

std::size_t PythonRobot::feed(const std::string& sensor, const py::object& stamps, const py::object& arrivals,
                              const std::string& payload, const py::dict& columns) {
  const Turn turn(*this);
  const auto fail = [&](const std::string& what) { throw DataError("feed \"" + sensor + "\": " + what); };
  if (!fed_) fail("the robot reads its measurements from its source; build it with feed=True");
  if (result_) fail("the robot is finished");
  const int index = session_->robot().rig.find(sensor);
  if (index < 0) fail("is not a sensor of the configuration");
  const auto place = static_cast<std::size_t>(index);
  const MeasurementBlock block(sensor, stamps, arrivals, payload, columns);
  const std::string& wanted = session_->robot().rig.mountings()[place].payload;
  if (!wanted.empty() && wanted != block.type())
    fail("the sensor takes " + wanted + ", not " + std::string(block.type()));

  const py::gil_scoped_release released;
  fed_->add(place, block.make(static_cast<std::uint32_t>(index), fed_->last_arrival(place).value_or(Time::min())));
  return block.size();
}

StepRecord PythonRobot::front(std::int64_t at_ns) const {
  const Turn turn(*this);
  const py::gil_scoped_release released;
  StepRecord record;
  record.stamp = Time(Duration(at_ns));
  record.belief = session_->fusion().front(record.stamp);
  record.pose_covariance = pose_covariance(record.belief, session_->fusion().layout());
  record.effective_sample_size = std::numeric_limits<double>::quiet_NaN();
  record.started = true;
  record.health = session_->fusion().health().state;
  record.health_reason = session_->fusion().health().reason;
  record.datum = session_->fusion().datum();
  return record;
}

std::vector<std::string> PythonRobot::sensor_names() const {
  std::vector<std::string> names;
  for (const SensorSlot& slot : session_->robot().sensors) names.push_back(slot.name);
  return names;
}

std::vector<std::string> PythonRobot::map_names() const {
  std::vector<std::string> names;
  for (const MapSlot& slot : session_->robot().maps) names.push_back(slot.name);
  return names;
}

std::vector<std::string> PythonRobot::state_names() const {
  static constexpr const char* kCore[kCoreStates] = {"x",   "y",   "z",   "roll",    "pitch",   "yaw",
                                                     "v_x", "v_y", "v_z", "omega_x", "omega_y", "omega_z"};
  const StateLayout& layout = session_->fusion().layout();
  std::vector<std::string> names;
  for (int i = 0; i < kCoreStates; ++i) {
    if (layout.active(i) >= 0) names.emplace_back(kCore[i]);
  }
  for (const StateLayout::Owner& owner : layout.owners()) {
    for (const BlockState& state : owner.block) names.push_back(owner.name + "." + state.name);
  }
  return names;
}

std::uint64_t PythonRobot::waiting() const {
  const Turn turn(*this);
  return fed_ ? fed_->waiting() : 0;
}

bool PythonRobot::started() const {
  const Turn turn(*this);
  return session_->fusion().started();
}

RunReport PythonRobot::run_report() const {
  const Turn turn(*this);
  return result_ ? result_->report : session_->fusion().report();
}

}  // namespace waymark::python
