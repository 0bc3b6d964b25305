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
#include "waymark/memory/cow.hpp"

namespace waymark::occupancy_grid {

using scan_matching::Cell;
using scan_matching::StoredDistance;
using scan_matching::TileIndex;

/// A square of cells: occupancy, and the distance to what is occupied. Unknown, free and occupied are three things.
/// Tiles share either part until one of them writes it: most scans change odds, and few of them distances.
class Tile {
 public:
  static constexpr int kBits = 5;
  static constexpr int kSide = 1 << kBits;  ///< cells
  static constexpr std::size_t kCells = std::size_t{kSide} * kSide;

  static constexpr std::int8_t kUnknown = -128;
  static constexpr double kOddsSteps = scan_matching::OddsSettings::kSteps;
  static constexpr int kReach = StoredDistance::kReach;
  static constexpr int kDistanceSteps = StoredDistance::kSteps;
  static constexpr std::uint8_t kFar = StoredDistance::kFar;

  using Odds = std::array<std::int8_t, kCells>;
  using Distances = std::array<std::uint8_t, kCells>;

  const Odds& odds() const { return odds_.read(); }
  const Distances& distances() const { return distances_.read(); }
  /// For writing; cloned first if other tiles share them. They stay where they are until the tile is copied.
  Odds& write_odds() { return odds_.write(); }
  Distances& write_distances() { return distances_.write(); }

  /// Place of a cell in its tile.
  static std::size_t place(std::int32_t x, std::int32_t y) {
    return static_cast<std::size_t>(y & (kSide - 1)) * kSide + static_cast<std::size_t>(x & (kSide - 1));
  }
  static TileIndex index_of(Cell cell) { return {cell.x >> kBits, cell.y >> kBits}; }
  static bool is_occupied(std::int8_t odds) { return odds > 0; }
  static bool is_known(std::int8_t odds) { return odds != kUnknown; }
  static double probability(std::int8_t odds) { return 1.0 / (1.0 + std::exp(-odds / kOddsSteps)); }

  std::size_t bytes(std::set<const void*>& seen) const;
  void save(OutArchive& out) const;
  void load(InArchive& in);

 private:
  static const Cow<Odds>& unknown();
  static const Cow<Distances>& far();

  Cow<Odds> odds_ = unknown();
  Cow<Distances> distances_ = far();
};

}  // namespace waymark::occupancy_grid
