// SPDX-License-Identifier: Apache-2.0
// A hall with boxes in it, and clouds and maps of it: for tests and benchmarks of the octomap grid.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <random>
#include <vector>

#include "map_modules/octomap_grid/cloud_insertion.hpp"
#include "map_modules/octomap_grid/cloud_observation.hpp"
#include "map_modules/octomap_grid/particle_octomap.hpp"
#include "waymark/config/config.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::octomap_grid_test {

using namespace waymark::octomap_grid;
using namespace waymark::scan_matching;

/// An axis-parallel box from `low` to `high` [m].
struct Box {
  Eigen::Vector3d low;
  Eigen::Vector3d high;
};

/// Walls, floor and ceiling are those of the first box, seen from inside; the others stand in it. All turned by 0.3 rad
/// about z against the map, since a wall on the border of two layers of voxels is in either.
struct Hall {
  std::vector<Box> boxes = {{{-6.03, -4.04, -0.53}, {8.02, 5.03, 3.04}},
                            {{2.0, 1.0, -0.53}, {3.0, 2.2, 1.3}},
                            {{-3.0, -2.5, -0.53}, {-2.2, -1.8, 3.04}},
                            {{4.0, -2.0, 0.5}, {5.5, -1.0, 1.1}}};

  static Eigen::Quaterniond turn() { return so3::from_rpy(0.0, 0.0, 0.3); }

  double range(const Eigen::Vector3d& p_map, const Eigen::Vector3d& ray_map) const {
    const Eigen::Vector3d from = turn().conjugate() * p_map;
    const Eigen::Vector3d ray = turn().conjugate() * ray_map;
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      double enter = -std::numeric_limits<double>::infinity();
      double leave = std::numeric_limits<double>::infinity();
      for (int k = 0; k < 3; ++k) {
        const double a = (boxes[i].low(k) - from(k)) / ray(k);
        const double b = (boxes[i].high(k) - from(k)) / ray(k);
        enter = std::max(enter, std::min(a, b));
        leave = std::min(leave, std::max(a, b));
      }
      if (i == 0) {
        nearest = leave;
      } else if (enter < leave && enter > 0.0) {
        nearest = std::min(nearest, enter);
      }
    }
    return nearest;
  }
};

/// Rings from 25° below to 15° above, as of a rotating scanner.
inline PointCloud cloud_of(const Hall& hall, const Pose& T_map_sensor, double sigma_m = 0.0, std::uint32_t seed = 1,
                           int rings = 16, int columns = 360) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0.0, 1.0);
  PointCloud cloud;
  for (int c = 0; c < columns; ++c) {
    for (int r = 0; r < rings; ++r) {
      const double azimuth = 2.0 * std::numbers::pi * (c + 0.31) / columns;
      const double elevation = (-25.0 + 40.0 * (r + 0.27) / rings) * std::numbers::pi / 180.0;
      const Eigen::Vector3d ray(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                                std::sin(elevation));
      const double range = hall.range(T_map_sensor.p, T_map_sensor.q * ray) + sigma_m * noise(random);
      cloud.points_m.emplace_back((range * ray).cast<float>());
    }
  }
  return cloud;
}

inline OctomapGridSettings settings(const char* yaml = "{}") { return OctomapGridSettings::read(Config::parse(yaml)); }

/// A scanner that looks down at a slant.
inline Pose tilted() { return {so3::from_rpy(0.1, 0.35, 0.2), {0.3, 0.1, 0.6}}; }

inline CloudObservation observed(const Hall& hall, const Pose& T_map_base, const Pose& T_base_sensor,
                                 const OctomapGridSettings& s, double sigma_m = 0.0, std::uint32_t seed = 1) {
  return observe(cloud_of(hall, T_map_base * T_base_sensor, sigma_m, seed), T_base_sensor, {}, s);
}

}  // namespace waymark::octomap_grid_test
