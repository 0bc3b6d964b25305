// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <set>

#include "map_modules/shared/scan_matching/cell.hpp"
#include "map_modules/shared/scan_matching/distance_field.hpp"
#include "map_modules/shared/scan_matching/scan_settings.hpp"
#include "waymark/io/archive.hpp"

namespace waymark::occupancy_grid {

using scan_matching::Cell;
using scan_matching::StoredDistance;
using scan_matching::TileIndex;

/// A square of cells: occupancy and the distance to what is occupied, cloned together. Unknown, free and occupied are
/// three things.
struct Tile {
  static constexpr int kBits = 5;
  static constexpr int kSide = 1 << kBits;  ///< cells
  static constexpr std::size_t kCells = std::size_t{kSide} * kSide;

  static constexpr std::int8_t kUnknown = -128;
  static constexpr double kOddsSteps = scan_matching::OddsSettings::kSteps;
  static constexpr int kReach = StoredDistance::kReach;
  static constexpr int kDistanceSteps = StoredDistance::kSteps;
  static constexpr std::uint8_t kFar = StoredDistance::kFar;

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
  static TileIndex index_of(Cell cell) { return {cell.x >> kBits, cell.y >> kBits}; }
  static bool is_occupied(std::int8_t odds) { return odds > 0; }
  static bool is_known(std::int8_t odds) { return odds != kUnknown; }
  static double probability(std::int8_t odds) { return 1.0 / (1.0 + std::exp(-odds / kOddsSteps)); }

  std::size_t bytes(std::set<const void*>&) const { return sizeof(Tile); }
  template <class Archive>
  void serialize(Archive& archive) {
    archive.bytes(odds.data(), kCells);
    archive.bytes(distance.data(), kCells);
  }
};

}  // namespace waymark::occupancy_grid
