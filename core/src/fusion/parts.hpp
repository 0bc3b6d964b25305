// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "estimation/process_model.hpp"
#include "fusion/committed.hpp"
#include "fusion/committed_steps.hpp"
#include "fusion/history.hpp"
#include "fusion/horizons.hpp"
#include "fusion/intake.hpp"
#include "fusion/map_extraction.hpp"
#include "fusion/new_events.hpp"
#include "fusion/startup.hpp"
#include "waymark/host/fusion.hpp"

namespace waymark {

/// The parts of the host. Their steps are in fusion.cpp, late.cpp and checkpoint.cpp.
struct Fusion::Parts {
  Parts(const FusionSettings& settings, std::vector<SensorSlot> sensors, std::vector<MapSlot> maps, Observer observer);

  // Processing of a measurement. (fusion.cpp)
  void dispatch(const Measurement& m, bool is_late);
  void commit(const Measurement& m);
  Fate predict_and_process(const Measurement& m);
  void notify_observer(const Measurement& m, Fate fate);
  void reject(const Measurement& m, const std::string& fault);
  void add_to_smoother(Fate fate);
  // Before the start, and after the pose was lost. (start.cpp)
  void await_start(const Measurement& m);
  void begin(const fusion::Start& start);
  void begin_anew(const fusion::Start& start);
  bool is_after_gap(const Measurement& m) const;
  fusion::Start last_pose(Time at) const;
  fusion::Start start_at(Time at, const Eigen::Vector3d& xyyaw, const Eigen::Matrix3d& P) const;
  void begin_at(Time at, const relocation::Place& place);
  void lose_pose(Time at, const std::string& why);
  /// True if there is a pose: the filter has started, and its pose is not lost.
  bool has_pose() const { return started && !searching; }
  // Late measurements. (late.cpp)
  void process_late(const Measurement& m);
  Fate roll_back_and_repeat(const Measurement& m);
  void note_too_late(const Measurement& m);
  void note_often_late(const Measurement& m);
  void mark_if_due();

  static constexpr const char* kUnsound = "the covariance is not positive definite any more";

  FusionSettings settings;
  StateLayout layout;
  estimation::ProcessModel process_model;
  fusion::Intake intake;
  fusion::Startup startup;
  fusion::MapExtraction maps;
  fusion::Committed committed;
  fusion::History history;
  std::optional<Datum> datum;
  fusion::CommittedSteps steps;
  fusion::PresentHorizon present;
  Observer observer;

  std::vector<Event> arrival_events;                 // of clocks and late measurements; not rolled back
  fusion::NewEvents new_arrival_events;              // of these
  std::optional<std::pair<Measurement, Fate>> last;  // the last reported measurement
  std::uint64_t arrived = 0;
  std::uint64_t turns = 0;  // measurements in the total order so far, late ones included
  UpdateList updates;       // of the last measurement
  bool started = false;
  bool searching = false;  // the pose was lost and is searched for
  bool repeating = false;  // measurements of a checkpoint are processed again: nothing is reported
};

/// The steps of Fig. 2.1 of the paper for one measurement, on `at`. `updates`: scratch.
Fate process(const Measurement& m, fusion::Horizon& at, const StateLayout& layout, UpdateList& updates);

}  // namespace waymark
