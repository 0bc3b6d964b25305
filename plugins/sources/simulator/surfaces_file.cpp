// SPDX-License-Identifier: Apache-2.0
#include "surfaces_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

namespace waymark::simulator {
namespace {

constexpr int kPiecesOfRounding = 10;

/// The last columns of a row in a world that is not level.
std::string base_columns(const World& world, double base_m) {
  return world.ground.is_level() ? std::string() : fmt::format(",{},", base_m);
}

void add_cylinders(const World& world, const std::vector<Cylinder>& cylinders, std::string& out) {
  for (const Cylinder& c : cylinders) {
    out += fmt::format("cylinder,{},{},,,{},{}{}\n", c.center.x(), c.center.y(), c.radius_m, c.height_m,
                       base_columns(world, c.base_m));
  }
}

void add_thing(const World& world, std::string_view kind, const Eigen::Vector2d& from, const Eigen::Vector2d& to,
               double half_width_m, double height_m, double base_m, std::string& out) {
  out += fmt::format("{},{},{},{},{},{},{}{}\n", kind, from.x(), from.y(), to.x(), to.y(), half_width_m, height_m,
                     base_columns(world, base_m));
}

/// A ramp is made of straight pieces, and has a wall at its higher end.
void add_deck(const World& world, const Deck& deck, std::string& out) {
  const auto at = [&](double s) { return Eigen::Vector2d(deck.from + s * deck.along); };
  if (deck.from_m == deck.to_m) {
    add_thing(world, "floor", at(0.0), at(deck.length_m), deck.half_width_m, deck.to_m, deck.base_m, out);
    return;
  }
  const auto add_piece = [&](double begin, double end) {
    const Eigen::Vector2d from = at(begin);
    const Eigen::Vector2d to = at(end);
    out += fmt::format("ramp,{},{},{},{},{},{},{},{}\n", from.x(), from.y(), to.x(), to.y(), deck.half_width_m,
                       deck.height(begin), deck.base_m, deck.height(end));
  };
  const double step = deck.rounding_m / kPiecesOfRounding;
  for (int i = 0; i < kPiecesOfRounding; ++i) add_piece(i * step, (i + 1) * step);
  const double second = deck.length_m - deck.rounding_m;
  if (second > deck.rounding_m) add_piece(deck.rounding_m, second);
  for (int i = 0; i < kPiecesOfRounding; ++i) add_piece(second + i * step, second + (i + 1) * step);
  const Eigen::Vector2d end = at(deck.to_m > deck.from_m ? deck.length_m : 0.0);
  const Eigen::Vector2d side = deck.half_width_m * Eigen::Vector2d(-deck.along.y(), deck.along.x());
  add_thing(world, "wall", end - side, end + side, 0.0, std::max(deck.from_m, deck.to_m), deck.base_m, out);
}

/// Wavelength as a vector against which the wave runs, phase and amplitude.
void add_wave(const Wave& wave, std::string& out) {
  out += fmt::format("wave,{},{},{},,,{},,\n", wave.k.x(), wave.k.y(), wave.phase_rad, wave.amplitude_m);
}

}  // namespace

std::string surfaces_csv(const World& world) {
  std::string out = "kind,x_m,y_m,x2_m,y2_m,half_width_m,height_m";
  out += world.ground.is_level() ? "\n" : ",base_m,height2_m\n";
  add_cylinders(world, world.landmarks, out);
  add_cylinders(world, world.stones, out);
  for (const Box& box : world.boxes) {
    const Eigen::Vector2d along = box.half_m.x() * Eigen::Vector2d(std::cos(box.yaw_rad), std::sin(box.yaw_rad));
    add_thing(world, "box", box.center - along, box.center + along, box.half_m.y(), box.height_m, box.base_m, out);
  }
  for (const Wall& wall : world.walls)
    add_thing(world, "wall", wall.from, wall.to, 0.0, wall.height_m, wall.base_m, out);
  for (const Deck& deck : world.ground.decks()) add_deck(world, deck, out);
  for (const Wave& wave : world.ground.waves()) add_wave(wave, out);
  const std::string_view end = world.ground.is_level() ? "\n" : ",,\n";
  if (world.has_ground) out += fmt::format("{},,,,,,0{}", world.ground.waves().empty() ? "level" : "ground", end);
  if (world.ceiling_m < World::kNothing) out += fmt::format("level,,,,,,{}{}", world.ceiling_m, end);
  return out;
}

}  // namespace waymark::simulator
