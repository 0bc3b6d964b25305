// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <set>
#include <utility>

#include "map_modules/shared/scan_matching/cell.hpp"
#include "map_modules/shared/scan_matching/distance_field.hpp"
#include "map_modules/shared/scan_matching/scan_settings.hpp"
#include "waymark/io/archive.hpp"
#include "waymark/memory/cow.hpp"

namespace waymark::occupancy_grid {

using scan_matching::Cell;
using scan_matching::StoredDistance;
using scan_matching::TileIndex;

/// How a tile is made of cells: a square, in strips of some rows each.
struct TileShape {
  static constexpr int kBits = 5;
  static constexpr int kSide = 1 << kBits;  ///< cells
  static constexpr std::size_t kCells = std::size_t{kSide} * kSide;
  static constexpr int kRowBits = 3;
  static constexpr int kRows = 1 << kRowBits;  ///< of a strip
  static constexpr std::size_t kStripCells = std::size_t{kSide} * kRows;
  static constexpr std::size_t kStrips = kCells / kStripCells;

  /// Place of a cell in its tile: the first strip, row by row, then the next one.
  static std::size_t place(std::int32_t x, std::int32_t y) {
    return static_cast<std::size_t>(y & (kSide - 1)) * kSide + static_cast<std::size_t>(x & (kSide - 1));
  }
  static std::size_t place_in_strip(std::int32_t x, std::int32_t y) {
    return static_cast<std::size_t>(y & (kRows - 1)) * kSide + static_cast<std::size_t>(x & (kSide - 1));
  }
};

/// A value for each cell of a tile. Tiles share a strip of them until one of them writes it: what differs between
/// particles are walls, and a wall is in a part of a tile.
template <class Value, Value kInitial>
class StripValues {
 public:
  using Strip = std::array<Value, TileShape::kStripCells>;

  Value operator[](std::size_t place) const {
    return strip(place / TileShape::kStripCells)[place % TileShape::kStripCells];
  }
  void set(std::size_t place, Value value) {
    write_strip(place / TileShape::kStripCells)[place % TileShape::kStripCells] = value;
  }
  const Value* strip(std::size_t i) const { return strips_[i].read().data(); }
  /// For writing; cloned first if other tiles share it. It stays where it is until the tile is copied.
  Value* write_strip(std::size_t i) { return strips_[i].write().data(); }

  std::size_t bytes(std::set<const void*>& seen) const;
  void save(OutArchive& out) const;
  void load(InArchive& in);

 private:
  static const Cow<Strip>& initial();
  template <std::size_t... i>
  static std::array<Cow<Strip>, TileShape::kStrips> all_initial(std::index_sequence<i...>) {
    return {((void)i, initial())...};
  }

  std::array<Cow<Strip>, TileShape::kStrips> strips_ = all_initial(std::make_index_sequence<TileShape::kStrips>());
};

/// A square of cells: occupancy, and the distance to what is occupied. Unknown, free and occupied are three things.
/// Tiles share either part until one of them writes it: most scans change odds, and few of them distances.
class Tile : public TileShape {
 public:
  static constexpr std::int8_t kUnknown = -128;
  static constexpr double kOddsSteps = scan_matching::OddsSettings::kSteps;
  static constexpr int kReach = StoredDistance::kReach;
  static constexpr int kDistanceSteps = StoredDistance::kSteps;
  static constexpr std::uint8_t kFar = StoredDistance::kFar;

  using Odds = StripValues<std::int8_t, kUnknown>;
  using Distances = StripValues<std::uint8_t, kFar>;

  Odds odds;
  Distances distances;

  static TileIndex index_of(Cell cell) { return {cell.x >> kBits, cell.y >> kBits}; }
  static bool is_occupied(std::int8_t odds) { return odds > 0; }
  static bool is_known(std::int8_t odds) { return odds != kUnknown; }
  static double probability(std::int8_t odds) { return 1.0 / (1.0 + std::exp(-odds / kOddsSteps)); }

  std::size_t bytes(std::set<const void*>& seen) const { return odds.bytes(seen) + distances.bytes(seen); }
  void save(OutArchive& out) const { out(odds, distances); }
  void load(InArchive& in) { in(odds, distances); }
};

}  // namespace waymark::occupancy_grid
