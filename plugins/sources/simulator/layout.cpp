// SPDX-License-Identifier: Apache-2.0
#include "layout.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "clutter.hpp"
#include "ground_plan.hpp"
#include "placing.hpp"
#include "streams.hpp"

namespace waymark::simulator {
namespace {

constexpr double kHeadroom = 0.5;  // [m]
constexpr int kClassless = 1;      // textures when the YAML asks for none

std::vector<Cylinder> listed(const Config& config, const Path& path) {
  const std::vector<double> numbers =
      config.numbers({"list_m", "m",
                      "instead of `count`, `area_m`, `radius_m`, `min_distance_m` and `course_clearance_m`: x, y, "
                      "radius of one cylinder after the other, one flat list"});
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
    if (clearance(cylinder.center, cylinder.radius_m, path) <= 0.0) {
      config.fail("list_m", fmt::format("the course runs through landmark {} at ({}, {})", i / 3 + 1, numbers[i],
                                        numbers[i + 1]));
    }
    cylinders.push_back(cylinder);
  }
  return cylinders;
}

std::vector<Cylinder> drawn(const Config& config, const Path& path, std::uint64_t seed) {
  const auto count = config.integer_in({"count", "cylinders drawn at random"}, 0, 100000, 24);
  const Area area = read_area(config);
  const Range radius = read_range(config, {"radius_m", "m", "smallest, largest radius"}, {0.1, 0.3});
  const double apart = config.non_negative({"min_distance_m", "m", "least distance between centres"}, 2.0);
  const double clear =
      config.non_negative({"course_clearance_m", "m", "least distance between the driven line and a surface"}, 1.0);

  std::vector<Cylinder> cylinders;
  for (std::int64_t i = 0; i < count; ++i) {
    Random random = stream(seed, Draw::landmarks, Duration{i});
    int tries = 0;
    for (; tries < kTriesPerThing; ++tries) {
      Cylinder next{};
      next.center = area.draw(random);
      next.radius_m = radius.draw(random);
      const bool crowded = std::ranges::any_of(cylinders, [&](const Cylinder& other) {
        return (other.center - next.center).norm() < std::max(apart, other.radius_m + next.radius_m);
      });
      if (crowded || clearance(next.center, next.radius_m, path) < clear) continue;
      cylinders.push_back(next);
      break;
    }
    if (tries == kTriesPerThing) {
      config.fail(
          "count",
          fmt::format("only {} of {} landmarks fit; enlarge area_m or lower min_distance_m or course_clearance_m", i,
                      count));
    }
  }
  return cylinders;
}

/// Which texture each landmark of an explicit list has: as in the YAML, else -1.
std::vector<int> listed_textures(const Config& config, std::size_t landmarks, int textures) {
  const std::vector<double> numbers =
      config.numbers({"list_texture", "", "with `list_m`: the texture of each, counted from 0", "at random"}, -1,
                     std::vector<double>{});
  if (numbers.empty()) return std::vector<int>(landmarks, -1);
  if (!config.has("list_m")) config.fail("list_texture", "is for landmarks of `list_m`; there is no such key");
  if (numbers.size() != landmarks) {
    config.fail("list_texture", fmt::format("{} textures for {} landmarks", numbers.size(), landmarks));
  }
  std::vector<int> chosen;
  for (const double number : numbers) {
    if (number != std::floor(number) || number < 0.0 || number >= textures) {
      config.fail("list_texture", fmt::format("{} is not a texture; 0 to {} are expected", number, textures - 1));
    }
    chosen.push_back(static_cast<int>(number));
  }
  return chosen;
}

/// Heights and textures have their own random numbers, so they move no landmark.
void dress(const Config& config, std::uint64_t seed, World& world) {
  const Range height = read_range(config, {"height_m", "m", "smallest, largest height"}, {3.0, 3.0});
  const auto count = static_cast<int>(config.integer_in(
      {"textures", "number of textures (hue, stripes, grain), each landmark has one of them"}, 1, 1000, kClassless));
  world.textures = draw_textures(count, seed);
  world.metal.assign(world.textures.size(), false);
  for (const double number :
       config.numbers({"metal_textures", "landmarks with these textures are magnetic"}, -1, std::vector<double>{})) {
    if (number != std::floor(number) || number < 0.0 || number >= count) {
      config.fail("metal_textures", fmt::format("{} is not a texture; 0 to {} are expected", number, count - 1));
    }
    world.metal[static_cast<std::size_t>(number)] = true;
  }
  const std::vector<int> chosen = listed_textures(config, world.landmarks.size(), count);
  for (std::size_t i = 0; i < world.landmarks.size(); ++i) {
    Random random = stream(seed, Draw::looks, Duration{static_cast<std::int64_t>(i)});
    world.landmarks[i].height_m = height.draw(random);
    const double texture = std::floor(count * random.uniform());
    world.landmarks[i].texture = static_cast<std::size_t>(chosen[i] >= 0 ? chosen[i] : texture);
  }
}

/// Where the robot is beside a thing, not above or below it.
Path beside(const Path& path, double base_m, double height_m) {
  Path out;
  std::ranges::copy_if(path, std::back_inserter(out),
                       [&](const Eigen::Vector3d& p) { return p.z() > base_m - kHeadroom && p.z() < height_m; });
  return out;
}

/// Both stand at `base_m`.
std::vector<Wall> read_walls(const Config& config, const Path& path, double base_m, double height_m) {
  const std::vector<double> numbers = config.numbers(
      {"walls_m", "m", "x1, y1, x2, y2 of one wall after the other, one flat list"}, -1, std::vector<double>{});
  if (numbers.size() % 4 != 0) {
    config.fail("walls_m", fmt::format("{} numbers; x1, y1, x2, y2 of each wall are expected", numbers.size()));
  }
  std::vector<Wall> walls;
  for (std::size_t i = 0; i < numbers.size(); i += 4) {
    const Wall wall{{numbers[i], numbers[i + 1]}, {numbers[i + 2], numbers[i + 3]}, base_m + height_m, 0, base_m};
    if ((wall.to - wall.from).norm() < 0.01) {
      config.fail("walls_m", fmt::format("wall {} has no length", i / 4 + 1));
    }
    if (clearance(wall, beside(path, base_m, wall.height_m)) < 0.1) {
      config.fail("walls_m", fmt::format("the course runs through wall {}", i / 4 + 1));
    }
    walls.push_back(wall);
  }
  return walls;
}

std::vector<Box> read_boxes(const Config& config, const Path& path, double base_m) {
  constexpr std::size_t kNumbers = 5;
  const std::vector<double> numbers = config.numbers(
      {"boxes_m", "m",
       "x, y of the middle, length along x, width along y, height of one box after the other, one flat list"},
      -1, std::vector<double>{});
  if (numbers.size() % kNumbers != 0) {
    config.fail("boxes_m",
                fmt::format("{} numbers; x, y, length along x, width along y, height of each box are expected",
                            numbers.size()));
  }
  std::vector<Box> boxes;
  boxes.reserve(numbers.size() / kNumbers);
  for (std::size_t i = 0; i < numbers.size(); i += kNumbers) {
    const Box box{{numbers[i], numbers[i + 1]},
                  {0.5 * numbers[i + 2], 0.5 * numbers[i + 3]},
                  0.0,
                  base_m + numbers[i + 4],
                  0,
                  base_m};
    if (!(box.half_m.minCoeff() > 0.0) || !(numbers[i + 4] > 0.0)) {
      config.fail("boxes_m", fmt::format("box {} measures {} x {} x {}; more than 0 is expected", i / kNumbers + 1,
                                         numbers[i + 2], numbers[i + 3], numbers[i + 4]));
    }
    const auto near = [&](const Eigen::Vector3d& p) {
      return ((p.head<2>() - box.center).cwiseAbs() - box.half_m).cwiseMax(0.0).norm() < 0.1;
    };
    if (std::ranges::any_of(beside(path, base_m, box.height_m), near))
      config.fail("boxes_m", fmt::format("the course runs through box {}", i / kNumbers + 1));
    boxes.push_back(box);
  }
  return boxes;
}

/// Adds a texture that belongs to no landmark; returns its index.
std::size_t add_texture(World& world, const Texture& texture) {
  world.textures.push_back(texture);
  world.metal.push_back(false);
  return world.textures.size() - 1;
}

void dress_surroundings(World& world, std::uint64_t seed) {
  const std::size_t stone = add_texture(world, {40.0, 0.06, 0.5, 0, 0.0, 0.3, seed + 1001});
  const std::size_t box = add_texture(world, {28.0, 0.35, 0.6, 1, 0.1, 0.1, seed + 1002});
  const std::size_t wall = add_texture(world, {35.0, 0.1, 0.72, 0, 0.0, 0.12, seed + 1003});
  add_texture(world, {75.0, 0.25, 0.42, 0, 0.0, 0.25, seed + 1004});  // the ground's is the last
  for (Cylinder& thing : world.stones) thing.texture = stone;
  for (Box& thing : world.boxes) thing.texture = box;
  for (Wall& thing : world.walls) thing.texture = wall;
}

/// Things that stand on uneven ground go down to its deepest hollow.
void sink_into(const Ground& ground, World& world) {
  for (Cylinder& thing : world.landmarks) thing.base_m -= ground.highest_wave_m();
  for (Cylinder& thing : world.stones) thing.base_m -= ground.highest_wave_m();
  for (Box& thing : world.boxes) thing.base_m -= ground.highest_wave_m();
  for (Wall& thing : world.walls) thing.base_m -= ground.highest_wave_m();
}

/// What stands on a floor.
void furnish(const Config& floor, const Path& path, World& world) {
  const double base_m = floor_height(floor);
  const double wall_height_m = floor.positive({"wall_height_m", "m", "height of this floor's walls"}, 2.5);
  for (const Wall& wall : read_walls(floor, path, base_m, wall_height_m)) world.walls.push_back(wall);
  for (const Box& box : read_boxes(floor, path, base_m)) world.boxes.push_back(box);
}

}  // namespace

World read_world(const Config& config, const Ground& ground, const Path& path, std::uint64_t default_seed) {
  World world;
  world.ground = ground;
  std::uint64_t seed = default_seed;
  if (config.has("landmarks")) {
    const Config landmarks = config.child({"landmarks", "vertical cylinders"});
    if (landmarks.has("list_m") && landmarks.has("count")) {
      landmarks.fail("count", "either count or list_m is expected, not both");
    }
    seed = static_cast<std::uint64_t>(
        landmarks.integer({"seed", "", "of positions, radii, heights and textures", "seed of the source"},
                          static_cast<std::int64_t>(default_seed)));
    world.landmarks = landmarks.has("list_m") ? listed(landmarks, path) : drawn(landmarks, path, seed);
    dress(landmarks, seed, world);
  }
  const double wall_height_m = config.positive({"wall_height_m", "m", "height of walls and corners"}, 2.5);
  world.walls = read_walls(config, path, 0.0, wall_height_m);
  world.boxes = read_boxes(config, path, 0.0);
  if (config.has("clutter")) {
    add_clutter(config.child({"clutter", "things that are not landmarks"}), path, wall_height_m, seed, world);
  }
  sink_into(ground, world);
  for (const Config& floor : config.items_or_empty(kFloorsKey)) furnish(floor, path, world);
  dress_surroundings(world, seed);
  world.has_ground =
      config.boolean({"ground", "false: the 3-D scanner sees no ground, as if it were open below"}, true);
  if (config.has("ceiling_m")) {
    world.ceiling_m = config.positive(
        {"ceiling_m", "m",
         "height of a ceiling over all of the world, for the 3-D scanner; the camera does not draw it", "none"});
  }
  return world;
}

}  // namespace waymark::simulator
