// SPDX-License-Identifier: Apache-2.0
#include "ground_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "streams.hpp"

namespace waymark::simulator {
namespace {

constexpr std::size_t kNumbersOfRamp = 7;
constexpr double kSteepest = 1.0;
constexpr int kWaves = 10;

void add_ramps(const Config& config, std::vector<Deck>& decks) {
  const std::vector<double> numbers =
      config.numbers({"ramps_m", "m",
                      "x, y, height of the middle of the one end, x, y, height of the middle of the other end, width "
                      "of one ramp after the other, one flat list; solid down to its lower end"},
                     -1, std::vector<double>{});
  const double rounding_m = config.positive(
      {"ramp_rounding_m", "m", "over so much of a ramp's length its slope begins, and ends at the other end"}, 0.5);
  if (numbers.size() % kNumbersOfRamp != 0) {
    config.fail("ramps_m", fmt::format("{} numbers; x, y, height of both ends and the width of each ramp are expected",
                                       numbers.size()));
  }
  for (std::size_t i = 0; i < numbers.size(); i += kNumbersOfRamp) {
    const std::size_t number = i / kNumbersOfRamp + 1;
    const Eigen::Vector2d from(numbers[i], numbers[i + 1]);
    const Eigen::Vector2d to(numbers[i + 3], numbers[i + 4]);
    const double length = (to - from).norm();
    const double lower = std::min(numbers[i + 2], numbers[i + 5]);
    if (!(numbers[i + 6] > 0.0)) {
      config.fail("ramps_m", fmt::format("ramp {} has width {}; more than 0 is expected", number, numbers[i + 6]));
    }
    if (lower < 0.0) config.fail("ramps_m", fmt::format("ramp {} starts at {} m, below the ground", number, lower));
    if (length < 2.0 * rounding_m) {
      config.fail("ramps_m", fmt::format("ramp {} is {} m long; at least twice ramp_rounding_m = {} is expected",
                                         number, length, rounding_m));
    }
    const Deck deck{from,           (to - from) / length, length,     0.5 * numbers[i + 6],
                    numbers[i + 2], numbers[i + 5],       rounding_m, lower};
    if (std::abs(deck.steepest()) > kSteepest) {
      config.fail("ramps_m", fmt::format("ramp {} has a slope of {}; at most {} is expected", number,
                                         std::abs(deck.steepest()), kSteepest));
    }
    decks.push_back(deck);
  }
}

void add_floor(const Config& floor, std::vector<Deck>& decks) {
  const std::vector<double> area = floor.numbers({"area_m", "m", "x_min, y_min, x_max, y_max of this floor"}, 4);
  if (area[0] >= area[2] || area[1] >= area[3]) floor.fail("area_m", "x_min, y_min, x_max, y_max are expected");
  const double height = floor_height(floor);
  const double thickness = floor.positive({"thickness_m", "m", "from its upper to its lower side"}, 0.2);
  if (thickness >= height)
    floor.fail("thickness_m", fmt::format("{} is not less than height_m = {}", thickness, height));
  const double length = area[2] - area[0];
  decks.push_back({{area[0], 0.5 * (area[1] + area[3])},
                   Eigen::Vector2d::UnitX(),
                   length,
                   0.5 * (area[3] - area[1]),
                   height,
                   height,
                   0.5 * length,
                   height - thickness});
}

/// Plane waves of equal amplitude in random directions; their lengths vary by a third or so.
std::vector<Wave> draw_waves(double height_m, double length_m, std::uint64_t seed) {
  std::vector<Wave> waves;
  waves.reserve(kWaves);
  for (int i = 0; i < kWaves; ++i) {
    Random random = stream(seed, Draw::waves, Duration{i});
    const double direction = 2.0 * std::numbers::pi * random.uniform();
    const double length = length_m * std::exp2(random.uniform() - 0.5);
    const double phase = 2.0 * std::numbers::pi * random.uniform();
    const double k = 2.0 * std::numbers::pi / length;
    waves.push_back({{k * std::cos(direction), k * std::sin(direction)}, phase, height_m * std::sqrt(2.0 / kWaves)});
  }
  return waves;
}

std::vector<Wave> read_waves(const Config& config, std::uint64_t default_seed) {
  const auto seed = static_cast<std::uint64_t>(
      config.integer({"seed", "", "of the bumps", "seed of the source"}, static_cast<std::int64_t>(default_seed)));
  const double height_m = config.positive({"height_m", "m", "r.m.s. of the ground's height"});
  const double length_m = config.positive({"length_m", "m", "from bump to bump, about"}, 3.0);
  if (height_m > 0.1 * length_m)
    config.fail("height_m", fmt::format("{} is more than a tenth of length_m = {}", height_m, length_m));
  return draw_waves(height_m, length_m, seed);
}

}  // namespace

double floor_height(const Config& floor) {
  return floor.positive({"height_m", "m", "height of its upper side over the ground"});
}

Ground read_ground(const Config& config, std::uint64_t seed) {
  std::vector<Deck> decks;
  add_ramps(config, decks);
  for (const Config& floor : config.items_or_empty(kFloorsKey)) add_floor(floor, decks);
  std::vector<Wave> waves;
  if (config.has("bumps")) waves = read_waves(config.child({"bumps", "uneven ground"}), seed);
  return {std::move(decks), std::move(waves)};
}

}  // namespace waymark::simulator
