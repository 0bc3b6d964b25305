// SPDX-License-Identifier: Apache-2.0
// Walls, and scans of them: for tests and benchmarks of the occupancy grid.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <numbers>
#include <random>
#include <vector>

#include "map_modules/occupancy_grid/particle_grid.hpp"
#include "map_modules/occupancy_grid/scan_insertion.hpp"
#include "map_modules/occupancy_grid/scan_observation.hpp"
#include "waymark/config/config.hpp"

namespace waymark::occupancy_grid_test {

using namespace waymark::occupancy_grid;
using namespace waymark::scan_matching;

/// A wall from (x1, y1) to (x2, y2) [m].
using Wall = std::array<double, 4>;

/// 10 m × 6 m with a niche, a pillar and an open door; askew, since a wall on the border of two rows of cells is in
/// either.
inline std::vector<Wall> room() {
  std::vector<Wall> walls = {{-4, -3, 6, -3}, {6, -3, 6, 1},    {6, 2, 6, 3},         {6, 3, 2, 3},
                             {2, 3, 2, 2},    {2, 2, 0.5, 2},   {0.5, 2, 0.5, 3},     {0.5, 3, -4, 3},
                             {-4, 3, -4, -3}, {3, -1, 3.4, -1}, {3.4, -1, 3.4, -0.6}, {3.4, -0.6, 3, -0.6},
                             {3, -0.6, 3, -1}};
  const Eigen::Rotation2Dd turn(0.2);
  for (Wall& w : walls) {
    const Eigen::Vector2d a = turn * Eigen::Vector2d(w[0], w[1]);
    const Eigen::Vector2d b = turn * Eigen::Vector2d(w[2], w[3]);
    w = {a.x(), a.y(), b.x(), b.y()};
  }
  return walls;
}

/// Two parallel walls without ends in sight.
inline std::vector<Wall> corridor() { return {{-500, -1.025, 500, -1.025}, {-500, 1.025, 500, 1.025}}; }

inline double range_to(const std::vector<Wall>& walls, const Eigen::Vector2d& from, double angle) {
  const Eigen::Vector2d ray(std::cos(angle), std::sin(angle));
  double nearest = std::numeric_limits<double>::infinity();
  for (const Wall& w : walls) {
    const Eigen::Vector2d a(w[0], w[1]);
    const Eigen::Vector2d along = Eigen::Vector2d(w[2], w[3]) - a;
    const double cross = ray.x() * along.y() - ray.y() * along.x();
    if (std::abs(cross) < 1e-12) continue;
    const Eigen::Vector2d to = a - from;
    const double range = (to.x() * along.y() - to.y() * along.x()) / cross;
    const double part = (to.x() * ray.y() - to.y() * ray.x()) / cross;
    if (range > 0.0 && part >= 0.0 && part <= 1.0) nearest = std::min(nearest, range);
  }
  return nearest;
}

/// 180 beams over 180 degrees, as of a SICK LMS; no return: 81 m.
inline LaserScan scan_of(const std::vector<Wall>& walls, const Eigen::Vector3d& xyyaw, double sigma_m = 0.0,
                         std::uint32_t seed = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0.0, 1.0);
  LaserScan scan;
  scan.step_rad = std::numbers::pi / 180.0;
  scan.start_rad = -0.5 * std::numbers::pi + 0.5 * scan.step_rad;
  for (int k = 0; k < 180; ++k) {
    const double range = range_to(walls, xyyaw.head<2>(), xyyaw.z() + scan.start_rad + k * scan.step_rad);
    scan.ranges_m.push_back(range < 80.0 ? static_cast<float>(range + sigma_m * noise(random)) : 81.0f);
  }
  return scan;
}

inline OccupancyGridSettings settings(const char* yaml = "{}") {
  return OccupancyGridSettings::read(Config::parse(yaml));
}

inline ScanObservation observed(const std::vector<Wall>& walls, const Eigen::Vector3d& xyyaw, double sigma_m = 0.0,
                                std::uint32_t seed = 1, const char* yaml = "{}") {
  return observe(scan_of(walls, xyyaw, sigma_m, seed), Pose{}, {}, settings(yaml).scan);
}

/// A map of the walls as a robot makes it that stands at these poses and knows them.
inline TileTree mapped(const std::vector<Wall>& walls, const std::vector<Eigen::Vector3d>& poses,
                       const char* yaml = "{}") {
  constexpr int kTimes = 3;
  TileTree tiles;
  ScanInsertion insertion;
  for (int i = 0; i < kTimes; ++i) {
    for (const Eigen::Vector3d& pose : poses)
      insertion.insert(tiles, pose, observed(walls, pose, 0.0, 1, yaml), settings());
  }
  return tiles;
}

}  // namespace waymark::occupancy_grid_test
