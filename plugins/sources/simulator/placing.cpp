// SPDX-License-Identifier: Apache-2.0
#include "placing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace waymark::simulator {

Eigen::Vector2d Area::draw(Random& random) const {
  const double x = low.x() + (high.x() - low.x()) * random.uniform();
  const double y = low.y() + (high.y() - low.y()) * random.uniform();
  return {x, y};
}

Range read_range(const Config& config, const Config::Key& key, const Range& fallback) {
  const std::vector<double> range = config.numbers(key, 2, {fallback.smallest, fallback.largest});
  if (!(range[0] > 0.0) || range[1] < range[0]) {
    config.fail(key.name, fmt::format("[{}, {}] is not a range of positive sizes", range[0], range[1]));
  }
  return {range[0], range[1]};
}

Area read_area(const Config& config) {
  const std::vector<double> area = config.numbers({"area_m", "m", "x_min, y_min, x_max, y_max of the centres"}, 4);
  if (area[0] >= area[2] || area[1] >= area[3]) config.fail("area_m", "x_min, y_min, x_max, y_max are expected");
  return {{area[0], area[1]}, {area[2], area[3]}};
}

double clearance(const Eigen::Vector2d& center, double radius_m, const Path& path) {
  double nearest = World::kNothing;
  for (const Eigen::Vector3d& p : path) nearest = std::min(nearest, (p.head<2>() - center).squaredNorm());
  return std::sqrt(nearest) - radius_m;
}

double distance(const Wall& wall, const Eigen::Vector2d& p) {
  const Eigen::Vector2d span = wall.to - wall.from;
  const double share = std::clamp((p - wall.from).dot(span) / span.squaredNorm(), 0.0, 1.0);
  return (wall.from + share * span - p).norm();
}

double clearance(const Wall& wall, const Path& path) {
  double nearest = World::kNothing;
  for (const Eigen::Vector3d& p : path) nearest = std::min(nearest, distance(wall, p.head<2>()));
  return nearest;
}

}  // namespace waymark::simulator
