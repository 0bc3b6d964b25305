// SPDX-License-Identifier: Apache-2.0
#include "simulated_lidar.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "streams.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::simulator {
namespace {

constexpr double kLidarPhase = 0.57;
constexpr int kSubRays = 7;  // that stand for one beam of finite width

}  // namespace

SimulatedLidar::SimulatedLidar(const Config& config, const Rig& rig)
    : SimulatedSensor(config, LaserScan::kType, 5.0, kLidarPhase),
      T_base_sensor_(rig.T_base_sensor(channel().sensor)),
      range_max_m_(config.positive(
          {"range_max_m", "m", "a beam without return shows this + 1: that is the `no_return_m` for a map module"},
          30.0)),
      start_rad_(kDegree *
                 config.number_in({"start_deg", "°", "first beam, counter-clockwise from the sensor's x axis"}, -360.0,
                                  360.0, -135.0)),
      step_rad_(kDegree * config.positive({"step_deg", "°", "from beam to beam, counter-clockwise"}, 0.5)),
      beams_(static_cast<int>(config.integer_in({"beams", "number of beams"}, 1, 100000, 541))),
      beam_interval_s_(config.number_in({"sweep_s", "s",
                                         "how long one scan takes: its beams then carry their own times after the "
                                         "stamp, and are seen from where the robot was; 0: all at the stamp"},
                                        0.0, 10.0, 0.0) /
                       beams_),
      sigma_m_(config.positive({"sigma_m", "m", "white noise of each range"}, 0.02)),
      miss_probability_(config.number_in(
          {"miss_probability", "a landmark is not there in a scan with this probability, drawn anew for each"}, 0.0,
          1.0, 0.0)),
      clutter_per_scan_(config.number_in({"clutter_per_scan",
                                          "mean number (Poisson) of cylinders that stand in one scan only: range "
                                          "uniform from 1 m, any bearing, radius 0.05 to 0.3 m"},
                                         0.0, 1000.0, 0.0)),
      beam_width_rad_(kDegree * config.number_in({"beam_width_deg", "°", "full width of a beam, seven rays; 0: a line"},
                                                 0.0, 10.0, 0.0)),
      mixed_probability_(config.number_in({"mixed_probability",
                                           "a wide beam that meets two surfaces shows a range between them, uniform, "
                                           "with this probability; else the nearer one"},
                                          0.0, 1.0, 0.5)),
      edge_m_(config.positive({"edge_m", "m", "ranges that differ more are two surfaces"}, 0.3)) {
  const Eigen::Vector3d rpy = so3::to_rpy(T_base_sensor_.q);
  if (std::hypot(rpy.x(), rpy.y()) > 1e-9) {
    config.fail("sensor", fmt::format("base_T_sensor of '{}' has roll or pitch; the simulated scanner is horizontal",
                                      channel().sensor));
  }
}

/// The world of one scan: without the cylinders that it misses, with its clutter.
World SimulatedLidar::seen(const Truth& truth, Duration stamp, const Pose& T_map_sensor) const {
  World world = truth.world;
  Random misses = stream(truth.seed, Draw::misses, stamp);
  std::erase_if(world.landmarks, [&](const Cylinder&) { return misses.uniform() < miss_probability_; });
  // Poisson by counting exponential waiting times.
  Random clutter = stream(truth.seed, Draw::clutter, stamp);
  constexpr double kNearest = 1.0;
  for (double sum = -std::log1p(-clutter.uniform()); sum < clutter_per_scan_; sum -= std::log1p(-clutter.uniform())) {
    const double range = kNearest + (range_max_m_ - kNearest) * clutter.uniform();
    const double bearing = start_rad_ + step_rad_ * (beams_ - 1) * clutter.uniform();
    const Eigen::Vector3d p = T_map_sensor * Eigen::Vector3d(range * std::cos(bearing), range * std::sin(bearing), 0.0);
    world.stones.push_back({p.head<2>(), 0.05 + 0.25 * clutter.uniform(), World::kNothing});
  }
  return world;
}

/// True range of one beam at an angle that counts from the map's x axis. A wide beam that meets surfaces in one piece
/// shows their mean; at an edge it shows the nearer one or, as time-of-flight scanners do, something between both.
double SimulatedLidar::measured(const World& world, const Pose& T_map_sensor, double angle_rad, Random& mixing) const {
  const auto cast = [&](double angle) {
    if (world.ground.is_level()) return world.cast(T_map_sensor.p, angle);
    const double azimuth = angle - T_map_sensor.yaw();
    return world.cast(T_map_sensor.p,
                      Eigen::Vector3d(T_map_sensor.q * Eigen::Vector3d(std::cos(azimuth), std::sin(azimuth), 0.0)));
  };
  if (beam_width_rad_ == 0.0) return cast(angle_rad);
  std::array<double, kSubRays> ranges{};
  for (int i = 0; i < kSubRays; ++i) {
    const double offset = beam_width_rad_ * ((i + 0.5) / kSubRays - 0.5);
    ranges[static_cast<std::size_t>(i)] = cast(angle_rad + offset);
  }
  // Drawn for every beam, so that what one beam meets does not change the others.
  const bool mixed = mixing.uniform() < mixed_probability_;
  const double share = mixing.uniform();

  const double foreground = std::ranges::min(ranges);
  double sum = 0.0;
  int near = 0;
  double background = World::kNothing;
  for (const double range : ranges) {
    if (range > range_max_m_) continue;
    if (range <= foreground + edge_m_) {
      sum += range;
      ++near;
    } else {
      background = std::min(background, range);
    }
  }
  if (near == 0) return World::kNothing;
  const double front = sum / near;
  return mixed && background < World::kNothing ? front + share * (background - front) : front;
}

std::shared_ptr<Payload> SimulatedLidar::sample(const Truth& truth, Duration time) {
  Pose T_map_sensor = truth.trajectory.at(time).pose() * T_base_sensor_;
  const bool as_it_is = miss_probability_ == 0.0 && clutter_per_scan_ == 0.0;
  const World disturbed = as_it_is ? World{} : seen(truth, time, T_map_sensor);
  const World& world = as_it_is ? truth.world : disturbed;
  Random random = stream(truth.seed, Draw::lidar, time);
  Random mixing = stream(truth.seed, Draw::mixing, time);
  auto scan = std::make_shared<LaserScan>();
  scan->start_rad = start_rad_;
  scan->step_rad = step_rad_;
  scan->beam_interval_s = beam_interval_s_;
  scan->ranges_m.reserve(static_cast<std::size_t>(beams_));
  for (int beam = 0; beam < beams_; ++beam) {
    const double noise = sigma_m_ * random.normal();
    if (beam_interval_s_ > 0.0)
      T_map_sensor = truth.trajectory.at(time + from_seconds(beam * beam_interval_s_)).pose() * T_base_sensor_;
    const double range = measured(world, T_map_sensor, T_map_sensor.yaw() + start_rad_ + beam * step_rad_, mixing);
    const double shown = range > range_max_m_ ? range_max_m_ + 1.0 : std::clamp(range + noise, 0.0, range_max_m_);
    scan->ranges_m.push_back(static_cast<float>(shown));
  }
  return scan;
}

}  // namespace waymark::simulator
