// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "waymark/config/config.hpp"
#include "waymark/math/random.hpp"
#include "world.hpp"

namespace waymark::simulator {

/// How often a place is drawn for one thing before the YAML asks for too much.
inline constexpr int kTriesPerThing = 10000;

/// Positions of the robot, about 0.1 m apart.
using Path = std::vector<Eigen::Vector3d>;

/// A range that a size is drawn from.
struct Range {
  double smallest;
  double largest;

  double draw(Random& random) const { return smallest + (largest - smallest) * random.uniform(); }
};

/// A rectangle that a centre is drawn from.
struct Area {
  Eigen::Vector2d low;
  Eigen::Vector2d high;

  Eigen::Vector2d draw(Random& random) const;
};

/// Reads [smallest, largest], both positive. Throws ConfigError.
Range read_range(const Config& config, const Config::Key& key, const Range& fallback);

/// Reads `area_m`: x_min, y_min, x_max, y_max. Throws ConfigError.
Area read_area(const Config& config);

/// Distance in the plan from the path to the surface of a disc, negative if the path runs through it; infinite without
/// path.
double clearance(const Eigen::Vector2d& center, double radius_m, const Path& path);

/// Distance in the plan from the path to a wall.
double clearance(const Wall& wall, const Path& path);

/// Distance from a point to a wall.
double distance(const Wall& wall, const Eigen::Vector2d& p);

}  // namespace waymark::simulator
