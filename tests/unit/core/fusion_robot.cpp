// SPDX-License-Identifier: Apache-2.0
#include "unit/core/fusion_robot.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "waymark/host/robot.hpp"

namespace waymark::test {

FusionRobot::FusionRobot(const std::string& yaml, std::vector<std::pair<std::string, std::shared_ptr<Sensor>>> own,
                         std::vector<MapSlot> maps) {
  host::Robot robot = host::Robot::live(Config::parse(yaml, "robot.yaml"), PluginLoader({WAYMARK_PLUGIN_DIR}), own);
  robot.maps = std::move(maps);
  fusion_ = robot.fusion([this](const Snapshot& snapshot) {
    const Measurement& m = snapshot.measurement();
    seen_.push_back({to_seconds(m.stamp.time_since_epoch()), m.sensor, snapshot.fate(),
                     snapshot.started() ? snapshot.belief() : Belief{}});
  });
}

FusionRobot& FusionRobot::play(const std::vector<Measurement>& log) {
  for (const Measurement& m : log) fusion_->add(m);
  fusion_->finish();
  return *this;
}

SensorReport FusionRobot::report(std::size_t sensor) const { return fusion_->report().sensors[sensor]; }
const Pose& FusionRobot::pose() const { return filter().mixture().mean.T_map_base; }
Eigen::Matrix3d FusionRobot::pose_P() const { return pose_covariance(filter().mixture(), fusion_->layout()); }
std::string FusionRobot::events() const {
  std::string all;
  for (const Event& event : fusion_->report().events) all += event.text + "\n";
  return all;
}

std::string FusionRobot::bytes() const {
  std::ostringstream stream;
  OutArchive out(stream);
  filter().save(out);
  return stream.str();
}

Measurement reading(double stamp, std::uint32_t sensor, std::shared_ptr<const Payload> payload) {
  Measurement m;
  m.stamp = at(stamp);
  m.arrival = m.stamp;
  m.sensor = sensor;
  m.payload = std::move(payload);
  return m;
}

Measurement twist(double stamp, double v, double w, std::uint32_t sensor) {
  auto payload = std::make_shared<BodyTwist>();
  payload->v_x_mps = v;
  payload->w_z_radps = w;
  return reading(stamp, sensor, payload);
}

Measurement fix(double stamp, double east, double north, std::uint32_t sensor) {
  auto payload = std::make_shared<GnssFix>();
  payload->p_map_antenna = {east, north, 0.0};
  return reading(stamp, sensor, payload);
}

void drive(std::vector<Measurement>& log, double from, double to, double v, double w, double rate) {
  const auto count = static_cast<int>(std::lround((to - from) * rate));
  for (int k = 0; k < count; ++k) log.push_back(twist(from + k / rate, v, w));
}

std::vector<Measurement> in_order(std::vector<Measurement> log) {
  std::stable_sort(log.begin(), log.end(), [](const auto& a, const auto& b) {
    return a.stamp != b.stamp ? a.stamp < b.stamp : a.sensor < b.sensor;
  });
  for (std::size_t i = 0; i < log.size(); ++i) log[i].sequence = i;
  return log;
}

}  // namespace waymark::test
