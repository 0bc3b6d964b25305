// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "map_modules/shared/scan_matching/cell.hpp"

namespace waymark::scan_matching {

/// How the distance of a cell to the nearest occupied one is stored, in one byte.
struct StoredDistance {
  static constexpr int kReach = 6;           ///< distances are kept up to this far [cells]
  static constexpr int kSteps = 25;          ///< in steps of 1/25 cell
  static constexpr std::uint8_t kFar = 255;  ///< nothing occupied within reach

  /// A cell within reach, and how far that is.
  struct Offset {
    std::int8_t x;
    std::int8_t y;
    std::uint8_t distance;
  };
  /// All of the disc, the nearest first.
  static const std::vector<Offset>& disc();
  /// Per distance: the first offset of the disc that is not nearer.
  static const std::array<std::uint8_t, 256>& first_at();
};

/// The distance to the nearest occupied cell, none of which is nearer than `at_least`.
template <class Window>
std::uint8_t search_distance(Window& window, int x, int y, std::uint8_t at_least) {
  const std::vector<StoredDistance::Offset>& offsets = StoredDistance::disc();
  for (std::size_t i = StoredDistance::first_at()[at_least]; i < offsets.size(); ++i) {
    const StoredDistance::Offset o = offsets[i];
    if (window.is_occupied(x + o.x, y + o.y)) return o.distance;
  }
  return StoredDistance::kFar;
}

/// Whether all four neighbours of a cell are occupied: to every other cell one of them is nearer.
template <class Window>
bool is_surrounded(Window& window, Cell cell) {
  return window.is_occupied(cell.x - 1, cell.y) && window.is_occupied(cell.x + 1, cell.y) &&
         window.is_occupied(cell.x, cell.y - 1) && window.is_occupied(cell.x, cell.y + 1);
}

/// Keeps the truncated distance of every cell to the nearest occupied one up to date: exactly what a distance transform
/// of the whole map would give. Cells are those of the window, which must reach 2 · `kReach` cells beyond them; what
/// `is_occupied(x, y)` returns is up to date already.
///
/// `freed` were occupied: what they determined is searched anew. `occupied` were not: they bring what is near nearer.
template <class Window>
void update_distances(std::span<const Cell> freed, std::span<const Cell> occupied, Window& window) {
  // What a freed cell determined holds its own distance; if another is as near, the search finds that.
  for (const Cell cell : freed) {
    for (const StoredDistance::Offset o : StoredDistance::disc()) {
      const int x = cell.x + o.x;
      const int y = cell.y + o.y;
      if (window.distance(x, y) != o.distance) continue;
      const std::uint8_t now = search_distance(window, x, y, o.distance);
      if (now != o.distance) window.set_distance(x, y, now);
    }
  }
  for (const Cell cell : occupied) {
    if (is_surrounded(window, cell)) {
      window.set_distance(cell.x, cell.y, 0);
      continue;
    }
    for (const StoredDistance::Offset o : StoredDistance::disc()) {
      const int x = cell.x + o.x;
      const int y = cell.y + o.y;
      if (window.distance(x, y) > o.distance) window.set_distance(x, y, o.distance);
    }
  }
}

}  // namespace waymark::scan_matching
