// SPDX-License-Identifier: Apache-2.0
#include "simulated_lidar_3d.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "streams.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::simulator {
namespace {

constexpr double kLidar3dPhase = 0.43;
constexpr std::int64_t kMostBeams = 4'000'000;  // of one cloud

/// Unit vectors, column after column, each from the lowest ring up.
std::vector<Eigen::Vector3d> read_directions(const Config& config, std::size_t rings, std::size_t columns) {
  const double lowest =
      kDegree *
      config.number_in({"elevation_min_deg", "°",
                        "elevation of the lowest ring above the sensor's x-y plane; a single ring is the lowest"},
                       -90.0, 90.0, -15.0);
  const double highest = kDegree * config.number_in({"elevation_max_deg", "°",
                                                     "elevation of the highest ring above the sensor's x-y plane"},
                                                    -90.0, 90.0, 15.0);
  const double start =
      kDegree *
      config.number_in(
          {"start_deg", "°", "first beam of every ring, counter-clockwise about the sensor's z axis from its x axis"},
          -360.0, 360.0, -180.0);
  const double step =
      kDegree * config.positive({"step_deg", "°", "from beam to beam in a ring, counter-clockwise"}, 1.0);
  if (highest < lowest) {
    config.fail("elevation_max_deg",
                fmt::format("{} is less than elevation_min_deg = {}", highest / kDegree, lowest / kDegree));
  }
  const double rise = rings > 1 ? (highest - lowest) / static_cast<double>(rings - 1) : 0.0;
  std::vector<Eigen::Vector3d> directions;
  directions.reserve(rings * columns);
  for (std::size_t column = 0; column < columns; ++column) {
    const double azimuth = start + step * static_cast<double>(column);
    for (std::size_t ring = 0; ring < rings; ++ring) {
      const double elevation = lowest + rise * static_cast<double>(ring);
      directions.emplace_back(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                              std::sin(elevation));
    }
  }
  return directions;
}

}  // namespace

SimulatedLidar3d::SimulatedLidar3d(const Config& config, const Rig& rig, const World& world)
    : SimulatedSensor(config, PointCloud::kType, 10.0, kLidar3dPhase),
      T_base_sensor_(rig.T_base_sensor(channel().sensor)),
      range_max_m_(config.positive(
          {"range_max_m", "m", "what is further away does not come back: it is not in the cloud"}, 30.0)),
      sigma_m_(config.positive({"sigma_m", "m", "white noise of each range"}, 0.02)),
      sweep_s_(config.number_in(
          {"sweep_s", "s",
           "how long one turn takes: the points then carry their own times after the stamp, and are seen from where "
           "the robot was; 0: all at the stamp. The cloud arrives no later for it: that is `delay_s`"},
          0.0, 10.0, 0.0)),
      rings_(static_cast<std::size_t>(config.integer_in(
          {"rings", "cones of beams around the sensor's z axis, evenly spaced in elevation"}, 1, 1024, 16))),
      columns_(static_cast<std::size_t>(config.integer_in({"beams", "beams in every ring"}, 1, 100'000, 360))) {
  if (static_cast<std::int64_t>(rings_ * columns_) > kMostBeams) {
    config.fail("beams", fmt::format("{} beams in each of {} rings are {}; at most {} are expected", columns_, rings_,
                                     rings_ * columns_, kMostBeams));
  }
  const double height = T_base_sensor_.p.z();
  if (world.has_ground && height <= 0.0) {
    config.fail("sensor", fmt::format("base_T_sensor of '{}' has z = {} m; more than 0, above the ground, is expected",
                                      channel().sensor, height));
  }
  if (height >= world.ceiling_m) {
    config.fail("sensor", fmt::format("base_T_sensor of '{}' has z = {} m; less than ceiling_m = {} is expected",
                                      channel().sensor, height, world.ceiling_m));
  }
  directions_ = read_directions(config, rings_, columns_);
}

std::shared_ptr<Payload> SimulatedLidar3d::sample(const Truth& truth, Duration time) {
  auto cloud = std::make_shared<PointCloud>();
  cloud->points_m.reserve(directions_.size());
  if (sweep_s_ > 0.0) cloud->offsets_s.reserve(directions_.size());
  Random random = stream(truth.seed, Draw::clouds, time);
  Pose T_map_sensor = truth.trajectory.at(time).pose() * T_base_sensor_;
  for (std::size_t i = 0; i < directions_.size(); ++i) {
    const std::size_t column = i / rings_;
    const double offset_s = sweep_s_ * static_cast<double>(column) / static_cast<double>(columns_);
    if (sweep_s_ > 0.0 && i % rings_ == 0)
      T_map_sensor = truth.trajectory.at(time + from_seconds(offset_s)).pose() * T_base_sensor_;
    // Drawn for every beam, so that what one beam meets does not change the others.
    const double noise = sigma_m_ * random.normal();
    const double range = truth.world.cast(T_map_sensor.p, Eigen::Vector3d(T_map_sensor.q * directions_[i]));
    if (range > range_max_m_) continue;
    const double shown = std::clamp(range + noise, 0.0, range_max_m_);
    cloud->points_m.emplace_back((shown * directions_[i]).cast<float>());
    if (sweep_s_ > 0.0) cloud->offsets_s.push_back(static_cast<float>(offset_s));
  }
  return cloud;
}

}  // namespace waymark::simulator
