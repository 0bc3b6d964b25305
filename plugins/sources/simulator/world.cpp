// SPDX-License-Identifier: Apache-2.0
#include "world.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "streams.hpp"

namespace waymark::simulator {
namespace {

constexpr int kTriesPerCylinder = 10000;

/// Distance from the path to the cylinder's surface, negative if the path runs through it.
double clearance(const Cylinder& cylinder, const std::vector<Eigen::Vector2d>& path) {
  double nearest = World::kNothing;
  for (const Eigen::Vector2d& p : path) nearest = std::min(nearest, (p - cylinder.center).squaredNorm());
  return std::sqrt(nearest) - cylinder.radius_m;
}

World listed(const Config& config, const std::vector<Eigen::Vector2d>& path) {
  const std::vector<double> numbers = config.numbers("list_m");
  if (numbers.size() % 3 != 0) {
    config.fail("list_m", fmt::format("{} numbers; x, y, radius of each landmark are expected", numbers.size()));
  }
  std::vector<Cylinder> cylinders;
  for (std::size_t i = 0; i < numbers.size(); i += 3) {
    const Cylinder cylinder{{numbers[i], numbers[i + 1]}, numbers[i + 2]};
    if (!(cylinder.radius_m > 0.0)) {
      config.fail("list_m",
                  fmt::format("landmark {} has radius {}; more than 0 is expected", i / 3 + 1, cylinder.radius_m));
    }
    if (clearance(cylinder, path) <= 0.0) {
      config.fail("list_m", fmt::format("the course runs through landmark {} at ({}, {})", i / 3 + 1, numbers[i],
                                        numbers[i + 1]));
    }
    cylinders.push_back(cylinder);
  }
  return World(std::move(cylinders));
}

World drawn(const Config& config, const std::vector<Eigen::Vector2d>& path, std::uint64_t default_seed) {
  const auto count = config.integer_in("count", 0, 100000, 24);
  const std::vector<double> area = config.numbers("area_m", 4);
  if (area[0] >= area[2] || area[1] >= area[3]) config.fail("area_m", "x_min, y_min, x_max, y_max are expected");
  const std::vector<double> radius = config.numbers("radius_m", 2, {0.1, 0.3});
  if (!(radius[0] > 0.0) || radius[1] < radius[0]) {
    config.fail("radius_m", fmt::format("[{}, {}] is no range of positive radii", radius[0], radius[1]));
  }
  const double apart = config.non_negative("min_distance_m", 2.0);
  const double clear = config.non_negative("course_clearance_m", 1.0);
  const auto seed = static_cast<std::uint64_t>(config.integer("seed", static_cast<std::int64_t>(default_seed)));

  std::vector<Cylinder> cylinders;
  for (std::int64_t i = 0; i < count; ++i) {
    Random random = stream(seed, Draw::landmarks, Duration{i});
    int tries = 0;
    for (; tries < kTriesPerCylinder; ++tries) {
      Cylinder next{};
      next.center.x() = area[0] + (area[2] - area[0]) * random.uniform();
      next.center.y() = area[1] + (area[3] - area[1]) * random.uniform();
      next.radius_m = radius[0] + (radius[1] - radius[0]) * random.uniform();
      const bool crowded = std::ranges::any_of(cylinders, [&](const Cylinder& other) {
        return (other.center - next.center).norm() < std::max(apart, other.radius_m + next.radius_m);
      });
      if (crowded || clearance(next, path) < clear) continue;
      cylinders.push_back(next);
      break;
    }
    if (tries == kTriesPerCylinder) {
      config.fail(
          "count",
          fmt::format("only {} of {} landmarks fit; enlarge area_m or lower min_distance_m or course_clearance_m", i,
                      count));
    }
  }
  return World(std::move(cylinders));
}

}  // namespace

double World::cast(const Eigen::Vector2d& origin, double angle_rad) const {
  const Eigen::Vector2d direction(std::cos(angle_rad), std::sin(angle_rad));
  double nearest = kNothing;
  for (const Cylinder& cylinder : cylinders_) {
    const Eigen::Vector2d to_center = cylinder.center - origin;
    const double along = to_center.dot(direction);
    const double squared_aside = to_center.squaredNorm() - along * along;
    const double squared_half_chord = cylinder.radius_m * cylinder.radius_m - squared_aside;
    if (squared_half_chord < 0.0) continue;
    const double half_chord = std::sqrt(squared_half_chord);
    const double front = along - half_chord;
    const double distance = front >= 0.0 ? front : along + half_chord;
    if (distance >= 0.0) nearest = std::min(nearest, distance);
  }
  return nearest;
}

World read_world(const Config& config, const std::vector<Eigen::Vector2d>& path, std::uint64_t default_seed) {
  if (config.has("list_m") && config.has("count")) config.fail("count", "either count or list_m is expected, not both");
  return config.has("list_m") ? listed(config, path) : drawn(config, path, default_seed);
}

}  // namespace waymark::simulator
