// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "unit/core/beliefs.hpp"
#include "waymark/host/robot.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::test {

/// What an observer saw after one measurement.
struct Seen {
  double stamp;
  std::uint32_t sensor;
  Fate fate;
  Belief belief;  ///< empty before the start
};

/// A robot built from YAML with the real sensor plugins, and what its observer saw.
class FusionRobot {
 public:
  explicit FusionRobot(const std::string& yaml, const host::OwnSensors& own = {}, std::vector<MapSlot> maps = {}) {
    host::Robot robot = host::Robot::live(Config::parse(yaml, "robot.yaml"), PluginLoader({WAYMARK_PLUGIN_DIR}), own);
    robot.maps = std::move(maps);
    fusion_ = robot.fusion([this](const Snapshot& snapshot) {
      const Measurement& m = snapshot.measurement();
      seen_.push_back({to_seconds(m.stamp.time_since_epoch()), m.sensor, snapshot.fate(),
                       snapshot.started() ? snapshot.belief() : Belief{}});
    });
  }

  Fusion& fusion() { return *fusion_; }
  const std::vector<Seen>& seen() const { return seen_; }
  /// Plays a log that arrives in its order.
  FusionRobot& play(const std::vector<Measurement>& log) {
    for (const Measurement& m : log) fusion_->add(m);
    fusion_->finish();
    return *this;
  }
  SensorReport report(std::size_t sensor) const { return fusion_->report().sensors[sensor]; }
  const Pose& pose() const { return fusion_->filter().mixture().mean.T_map_base; }
  Eigen::Matrix3d pose_P() const { return pose_covariance(fusion_->filter().mixture(), fusion_->layout()); }
  std::string events() const {
    std::string all;
    for (const Event& event : fusion_->report().events) all += event.text + "\n";
    return all;
  }
  std::string bytes() const {
    std::ostringstream stream;
    OutArchive out(stream);
    fusion_->filter().save(out);
    return stream.str();
  }

 private:
  std::vector<Seen> seen_;
  std::unique_ptr<Fusion> fusion_;
};

inline Measurement reading(double stamp, std::uint32_t sensor, std::shared_ptr<const Payload> payload) {
  Measurement m;
  m.stamp = at(stamp);
  m.arrival = m.stamp;
  m.sensor = sensor;
  m.payload = std::move(payload);
  return m;
}

inline Measurement twist(double stamp, double v, double w = 0.0, std::uint32_t sensor = 0) {
  auto payload = std::make_shared<BodyTwist>();
  payload->v_x_mps = v;
  payload->w_z_radps = w;
  return reading(stamp, sensor, payload);
}

inline Measurement fix(double stamp, double east, double north, std::uint32_t sensor = 1) {
  auto payload = std::make_shared<GnssFix>();
  payload->p_map_antenna = {east, north, 0.0};
  return reading(stamp, sensor, payload);
}

/// Twists at `rate` from `from` to before `to`.
inline void drive(std::vector<Measurement>& log, double from, double to, double v, double w = 0.0, double rate = 10.0) {
  const auto count = static_cast<int>(std::lround((to - from) * rate));
  for (int k = 0; k < count; ++k) log.push_back(twist(from + k / rate, v, w));
}

/// In the order of stamps (then sensors), with sequence numbers in that order: what a source delivers.
inline std::vector<Measurement> in_order(std::vector<Measurement> log) {
  std::stable_sort(log.begin(), log.end(), [](const auto& a, const auto& b) {
    return a.stamp != b.stamp ? a.stamp < b.stamp : a.sensor < b.sensor;
  });
  for (std::size_t i = 0; i < log.size(); ++i) log[i].sequence = i;
  return log;
}

inline const std::string kWheels = "  - { name: wheels, plugin: odometry, model: twist }\n";
inline std::string gps(const std::string& more = "") {
  return "  - { name: gps, plugin: dgps, base_p_antenna_m: none, sigma_m: 0.1" + (more.empty() ? "" : ", " + more) +
         " }\n";
}
inline const std::string kAtOrigin =
    "initial: { x_m: 0, y_m: 0, position_sigma_m: 0.1, yaw_deg: 0, yaw_sigma_deg: 5 }\n";

}  // namespace waymark::test
