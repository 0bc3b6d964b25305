// SPDX-License-Identifier: Apache-2.0
#include "clutter.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "streams.hpp"

namespace waymark::simulator {
namespace {

/// Each kind draws from its own range of numbers, so that more stones move no box.
constexpr std::int64_t kNumbersPerKind = 1'000'000;
enum class Kind : std::int64_t { stone, box, corner };

/// A disc around a thing that nothing else may touch.
struct Footprint {
  Eigen::Vector2d center;
  double radius_m;
};

/// Draws things until they fit, and remembers where they stand.
class Placing {
 public:
  Placing(const Config& config, const Path& path, std::uint64_t seed, const World& world)
      : config_(config),
        path_(path),
        seed_(seed),
        area_(read_area(config)),
        clear_m_(config.non_negative(
            {"course_clearance_m", "m", "least distance between the driven line and a footprint"}, 0.7)),
        apart_m_(config.non_negative(
            {"min_distance_m", "m", "least distance to landmarks and to each other, between footprints"}, 0.5)),
        walls_(world.walls) {
    for (const Cylinder& landmark : world.landmarks) taken_.push_back({landmark.center, landmark.radius_m});
    for (const Box& box : world.boxes) taken_.push_back({box.center, box.half_m.norm()});
  }

  /// Calls `draw(random)`, which returns the radius of a footprint, until it fits; `put(center, random)` then puts the
  /// thing there.
  template <class DrawRadius, class Put>
  void place(const Config::Key& key, Kind kind, const DrawRadius& draw, const Put& put) {
    const auto count = config_.integer_in(key, 0, 10000, 0);
    for (std::int64_t i = 0; i < count; ++i) {
      Random random = stream(seed_, Draw::obstacles, Duration{static_cast<std::int64_t>(kind) * kNumbersPerKind + i});
      int tries = 0;
      for (; tries < kTriesPerThing; ++tries) {
        const Eigen::Vector2d center = area_.draw(random);
        const double radius = draw(random);
        if (!fits({center, radius})) continue;
        taken_.push_back({center, radius});
        put(center, random);
        break;
      }
      if (tries == kTriesPerThing) {
        config_.fail(
            key.name,
            fmt::format("only {} of {} fit; enlarge area_m or lower min_distance_m or course_clearance_m", i, count));
      }
    }
  }

 private:
  bool fits(const Footprint& next) const {
    if (clearance(next.center, next.radius_m, path_) < clear_m_) return false;
    const auto near = [&](const Footprint& other) {
      return (other.center - next.center).norm() < other.radius_m + next.radius_m + apart_m_;
    };
    const auto touches = [&](const Wall& wall) { return distance(wall, next.center) < next.radius_m; };
    return std::ranges::none_of(taken_, near) && std::ranges::none_of(walls_, touches);
  }

  const Config& config_;
  const Path& path_;
  std::uint64_t seed_;
  Area area_;
  double clear_m_;
  double apart_m_;
  std::vector<Wall> walls_;
  std::vector<Footprint> taken_;
};

}  // namespace

void add_clutter(const Config& config, const Path& path, double wall_height_m, std::uint64_t default_seed,
                 World& world) {
  const auto seed = static_cast<std::uint64_t>(
      config.integer({"seed", "", "of the clutter", "landmarks.seed"}, static_cast<std::int64_t>(default_seed)));
  const Range stone_radius =
      read_range(config, {"stone_radius_m", "m", "radius of a stone: smallest, largest"}, {0.1, 0.3});
  const Range stone_height =
      read_range(config, {"stone_height_m", "m", "height of a stone: smallest, largest"}, {0.35, 0.5});
  const Range box_size = read_range(config, {"box_size_m", "m", "both sides of a box: smallest, largest"}, {0.2, 0.6});
  const Range box_height = read_range(config, {"box_height_m", "m", "height of a box: smallest, largest"}, {0.35, 0.8});
  const Range corner_size =
      read_range(config, {"corner_size_m", "m", "length of both walls of a corner: smallest, largest"}, {0.5, 1.5});

  Placing placing(config, path, seed, world);
  double radius = 0.0;
  placing.place(
      {"stones", "how many low cylinders"}, Kind::stone,
      [&](Random& random) { return radius = stone_radius.draw(random); },
      [&](const Eigen::Vector2d& center, Random& random) {
        world.stones.push_back({center, radius, stone_height.draw(random)});
      });

  Eigen::Vector2d half(0.0, 0.0);
  placing.place(
      {"boxes", "how many boxes"}, Kind::box,
      [&](Random& random) {
        half.x() = 0.5 * box_size.draw(random);
        half.y() = 0.5 * box_size.draw(random);
        return half.norm();
      },
      [&](const Eigen::Vector2d& center, Random& random) {
        const double yaw = std::numbers::pi * random.uniform();
        world.boxes.push_back({center, half, yaw, box_height.draw(random)});
      });

  double leg = 0.0;
  placing.place(
      {"corners", "how many pairs of walls at a right angle"}, Kind::corner,
      [&](Random& random) { return leg = corner_size.draw(random); },
      [&](const Eigen::Vector2d& center, Random& random) {
        const double yaw = 2.0 * std::numbers::pi * random.uniform();
        const Eigen::Vector2d along(std::cos(yaw), std::sin(yaw));
        const Eigen::Vector2d across(-along.y(), along.x());
        world.walls.push_back({center, center + leg * along, wall_height_m});
        world.walls.push_back({center, center + leg * across, wall_height_m});
      });
}

}  // namespace waymark::simulator
