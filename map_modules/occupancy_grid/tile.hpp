// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace waymark::grid {

/// A cell, counted from the map's origin: cell (0, 0) has its lower left corner there.
struct Cell {
  std::int32_t x = 0;
  std::int32_t y = 0;

  bool operator==(const Cell&) const = default;
};

/// A square of cells: occupancy and the distance to what is occupied, cloned together. Unknown, free and occupied are
/// three things.
struct Tile {
  static constexpr int kBits = 5;
  static constexpr int kSide = 1 << kBits;  ///< cells
  static constexpr std::size_t kCells = std::size_t{kSide} * kSide;

  static constexpr std::int8_t kUnknown = -128;
  static constexpr double kOddsSteps = 20.0;  ///< log-odds are kept in steps of 1/20
  static constexpr int kReach = 6;            ///< distances are kept up to this far [cells]
  static constexpr int kDistanceSteps = 25;   ///< in steps of 1/25 cell
  static constexpr std::uint8_t kFar = 255;   ///< nothing occupied within reach

  std::array<std::int8_t, kCells> odds;
  std::array<std::uint8_t, kCells> distance;

  Tile() {
    odds.fill(kUnknown);
    distance.fill(kFar);
  }
  /// Place of a cell in its tile.
  static std::size_t place(std::int32_t x, std::int32_t y) {
    return static_cast<std::size_t>(y & (kSide - 1)) * kSide + static_cast<std::size_t>(x & (kSide - 1));
  }
  static bool is_occupied(std::int8_t odds) { return odds > 0; }
  static bool is_known(std::int8_t odds) { return odds != kUnknown; }
  static double probability(std::int8_t odds) { return 1.0 / (1.0 + std::exp(-odds / kOddsSteps)); }
};

/// What is nowhere written: all unknown, nothing near.
inline const Tile& empty_tile() {
  static const Tile tile;
  return tile;
}

/// Where a tile lies, counted in tiles.
struct TileIndex {
  std::int32_t x = 0;
  std::int32_t y = 0;

  bool operator==(const TileIndex&) const = default;
  static TileIndex of(Cell cell) { return {cell.x >> Tile::kBits, cell.y >> Tile::kBits}; }
};

/// A rectangle of tiles; `high` belongs to it.
struct TileRect {
  TileIndex low;
  TileIndex high;

  int width() const { return high.x - low.x + 1; }
  int height() const { return high.y - low.y + 1; }
  std::size_t size() const { return static_cast<std::size_t>(width()) * static_cast<std::size_t>(height()); }
};

}  // namespace waymark::grid
