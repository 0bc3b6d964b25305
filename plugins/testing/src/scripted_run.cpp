// SPDX-License-Identifier: Apache-2.0
#include "scripted_run.hpp"

#include <array>
#include <chrono>
#include <cmath>

#include "waymark/interface/payloads.hpp"

namespace waymark::testing {

namespace {

constexpr std::size_t kSensors = 4;

/// A payload that no plugin knows.
struct Unheard : PayloadOf<Unheard> {
  static constexpr std::string_view kType = "waymark_testing/Unheard@1";
  double loudness_db = 0.0;

  template <class Visitor>
  static void fields(Visitor&& field) {
    field(&Unheard::loudness_db, {.names = {"loudness_db"}, .unit = "dB", .meaning = "loudness"});
  }
};

Time time_of(std::size_t step) { return Time(std::chrono::milliseconds(100'000 + 100 * static_cast<int>(step))); }

/// Along a circle of 10 m radius, at 1 m/s.
Pose pose_of(std::size_t step) {
  const double turn = 0.01 * static_cast<double>(step);
  Pose pose = Pose::planar(10.0 * std::sin(turn), 10.0 * (1.0 - std::cos(turn)), turn);
  pose.p.z() = 0.3;
  return pose;
}

std::shared_ptr<const Payload> payload_of(std::size_t step) {
  const double t = 0.1 * static_cast<double>(step);
  switch (step % kSensors) {
    case 0: {
      auto twist = std::make_shared<BodyTwist>();
      twist->v_x_mps = 1.0 + 0.01 * t;
      twist->w_z_radps = 0.1;
      return twist;
    }
    case 1: {
      auto fix = std::make_shared<GnssFix>();
      fix->p_map_antenna = pose_of(step).p;
      fix->latitude_deg = 49.0 + 1e-6 * t;
      fix->longitude_deg = 8.0;
      fix->sigma_horizontal_m = 0.5;
      return fix;
    }
    case 2: {
      auto scan = std::make_shared<LaserScan>();
      scan->start_rad = -0.1;
      scan->step_rad = 0.1;
      scan->ranges_m = {5.0f, INFINITY, static_cast<float>(3.0 + t)};
      return scan;
    }
    default:
      return std::make_shared<Unheard>();
  }
}

GridView grid(std::uint8_t free_percent) {
  GridView view{Pose::planar(-1.0, -1.0, 0.1), 0.5, 4, 3, {}};
  view.cells = {GridView::kUnknown, free_percent, 50, 99, 0, 100, 20, GridView::kUnknown, 80, 10, 30, 60};
  return view;
}

}  // namespace

ScriptedRun::ScriptedRun(StateLayout::Motion motion) : layout_(motion, {{"gps", {{"offset_east_m", 0.0, 0.5}}}}) {
  belief_.mean.block.setZero(layout_.block_size());
  belief_.P = 0.04 * ErrorMatrix::Identity(layout_.size(), layout_.size());
  health_.sensors.resize(kSensors);
}

const Rig& ScriptedRun::rig() {
  static const Rig rig({{"wheels", std::string(BodyTwist::kType), {}},
                        {"gps", std::string(GnssFix::kType), {}},
                        {"lidar", std::string(LaserScan::kType), Pose::planar(0.2, 0.0, 0.1)},
                        {"other", std::string(Unheard::kType), {}}});
  return rig;
}

std::shared_ptr<const Reference> ScriptedRun::reference() {
  auto reference = std::make_shared<Reference>();
  for (std::size_t k = 0; k < kSteps; k += 4) reference->trajectory.push_back({time_of(k), pose_of(k), k % 8 == 0});
  reference->landmarks.push_back({"pole 1", {3.0, 4.0}, 0.2});
  reference->landmarks.push_back({"corner, of \"unknown\" size", {-2.0, 1.0}, std::nan("")});
  return reference;
}

const Snapshot& ScriptedRun::at(std::size_t step) {
  constexpr std::array kFates{Fate::fused,    Fate::fused, Fate::mapped,  Fate::ignored,
                              Fate::fused,    Fate::gated, Fate::skipped, Fate::unusable,
                              Fate::held_out, Fate::late,  Fate::paired,  Fate::mistimed};
  constexpr std::size_t kLost = 30;  // for two steps
  measurement_ = {};
  measurement_.sensor = static_cast<std::uint32_t>(step % kSensors);
  measurement_.sequence = step;
  measurement_.stamp = measurement_.arrival = time_of(step);
  measurement_.payload = payload_of(step);
  started_ = step >= kSensors && step != kLost && step != kLost + 1;
  fate_ = step < kSensors ? Fate::before_start : kFates[step % kFates.size()];
  if (fate_ == Fate::late) measurement_.stamp -= std::chrono::seconds(2);
  if (fate_ == Fate::mistimed) measurement_.stamp += std::chrono::hours(24);
  counters_.fused = step / kSensors;
  if (step == kSteps / 3) datum_ = Datum{49.0, 8.0, 120.0};
  health_.state = step < kSensors || (step >= kLost && step < kLost + 2) ? Health::State::lost : Health::State::ok;
  health_.reason = health_.state == Health::State::lost ? "gps is faulty: 14 of the last 20 updates gated" : "";
  health_.sensors[1].state =
      health_.state == Health::State::lost ? SensorHealth::State::faulty : SensorHealth::State::ok;
  health_.sensors[1].reason = health_.state == Health::State::lost ? "14 of the last 20 updates gated" : "";
  belief_.stamp = time_of(step);
  belief_.mean.T_map_base = pose_of(step);
  belief_.mean.v_base.x() = 1.0;
  belief_.mean.w_base.z() = 0.1;
  if (started_) path_.push_back({belief_.stamp, belief_.mean.T_map_base});
  if (fate_ == Fate::mapped) ++mapping_steps_;
  return *this;
}

std::vector<ParticleView> ScriptedRun::particles() const {
  const Pose& mean = belief_.mean.T_map_base;
  return {{mean, 0.75}, {mean * Pose::planar(0.1, -0.1, 0.02), 0.25}};
}

std::vector<MapDescription> ScriptedRun::best_maps(MapDetail detail) const {
  MapDescription features{.module = "pillars", .landmarks = {}};
  for (int i = 0; i < 3; ++i) {
    LandmarkView landmark;
    landmark.id = i;
    landmark.p_map = {3.0 + i, 4.0};
    landmark.radius_m = i == 1 ? std::nan("") : 0.2;
    landmark.P.diagonal().setConstant(0.01);
    landmark.P_conditional.diagonal().setConstant(0.005);
    landmark.existence = 0.9;
    landmark.sightings = 3 * i + 1;
    landmark.confirmed = i < 2;
    landmark.birth = static_cast<std::uint64_t>(i) + 1;
    features.landmarks.push_back(landmark);
  }
  features.figures = {{"merged", 1.0}};
  features.sightings = {{belief_.stamp, {1.0, 2.0}, 0, true}};
  MapDescription dense{.module = "grid", .landmarks = {}, .figures = {{"cells", 12.0}}};
  if (detail == MapDetail::with_grids || detail == MapDetail::with_mixtures) dense.grid = grid(5);
  if (detail == MapDetail::with_mixtures) dense.mixture = grid(15);
  if (detail == MapDetail::with_files) dense.files = {{".txt", "a map\n", Pose::planar(1.0, 2.0, 0.0)}};
  return {features, dense};
}

RunReport ScriptedRun::report(std::size_t steps) {
  RunReport report;
  for (const Mounting& mounting : rig().mountings()) {
    SensorReport sensor;
    sensor.name = mounting.name;
    sensor.plugin = "scripted";
    sensor.is_motion_source = mounting.name == "wheels";
    sensor.measurements = sensor.fused = steps / kSensors;
    sensor.nis_sum = 2.0;
    sensor.nis_count = sensor.nis_dof = steps > 0 ? 2 : 0;
    sensor.first = steps > 0 ? time_of(0) : Time{};
    sensor.last = steps > 0 ? time_of(steps - 1) : Time{};
    report.sensors.push_back(std::move(sensor));
  }
  if (steps == 0) return report;
  report.bad_records.push_back({"log.csv:7", "3 columns, expected 4"});
  report.notices.emplace_back("a message of the source");
  report.events.push_back({"gps: 14 measurements in a row rejected", time_of(steps - 1), false});
  report.health = {4.0, 0.5, 0.2};
  report.matches.push_back({"grid", 12, 1, 2});
  report.mapping_steps = 4;
  report.resamplings = 1;
  return report;
}

}  // namespace waymark::testing
