// SPDX-License-Identifier: Apache-2.0
#include "distance_field.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace waymark::grid {

namespace {

/// A cell within reach, and how far that is in steps of the stored distance.
struct Offset {
  std::int8_t x;
  std::int8_t y;
  std::uint8_t distance;
};

/// All of the disc, the nearest first.
const std::vector<Offset>& disc() {
  static const std::vector<Offset> offsets = [] {
    std::vector<Offset> all;
    all.reserve(std::size_t{2 * Tile::kReach + 1} * (2 * Tile::kReach + 1));
    for (int y = -Tile::kReach; y <= Tile::kReach; ++y) {
      for (int x = -Tile::kReach; x <= Tile::kReach; ++x) {
        if (x * x + y * y > Tile::kReach * Tile::kReach) continue;
        const double steps = std::round(Tile::kDistanceSteps * std::sqrt(static_cast<double>(x * x + y * y)));
        all.push_back({static_cast<std::int8_t>(x), static_cast<std::int8_t>(y), static_cast<std::uint8_t>(steps)});
      }
    }
    std::ranges::stable_sort(all, {}, &Offset::distance);
    return all;
  }();
  return offsets;
}

/// Per distance: the first offset of the disc that is not nearer.
const std::array<std::uint8_t, 256>& first_at() {
  static const std::array<std::uint8_t, 256> first = [] {
    std::array<std::uint8_t, 256> table{};
    for (std::size_t d = 0; d < table.size(); ++d) {
      const auto it = std::ranges::lower_bound(disc(), d, {}, &Offset::distance);
      table[d] = static_cast<std::uint8_t>(it - disc().begin());
    }
    return table;
  }();
  return first;
}

/// The distance to the nearest occupied cell, none of which is nearer than `at_least`.
std::uint8_t search(const TileWindow& window, int x, int y, std::uint8_t at_least) {
  const std::vector<Offset>& offsets = disc();
  for (std::size_t i = first_at()[at_least]; i < offsets.size(); ++i) {
    const Offset o = offsets[i];
    if (Tile::is_occupied(window.odds(x + o.x, y + o.y))) return o.distance;
  }
  return Tile::kFar;
}

}  // namespace

void update_distances(std::span<const Cell> freed, std::span<const Cell> occupied, WritableWindow& window) {
  // What a freed cell determined holds its own distance; if another is as near, the search finds that.
  for (const Cell cell : freed) {
    for (const Offset o : disc()) {
      const int x = cell.x + o.x;
      const int y = cell.y + o.y;
      if (window.distance(x, y) != o.distance) continue;
      const std::uint8_t now = search(window, x, y, o.distance);
      if (now != o.distance) window.set_distance(x, y, now);
    }
  }
  for (const Cell cell : occupied) {
    for (const Offset o : disc()) {
      const int x = cell.x + o.x;
      const int y = cell.y + o.y;
      if (window.distance(x, y) > o.distance) window.set_distance(x, y, o.distance);
    }
  }
}

}  // namespace waymark::grid
