// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include "map_modules/shared/scan_matching/cell.hpp"

namespace waymark::scan_matching {

/// A rectangle of square tiles of 2^kBits cells a side, as a field of cells that count from its own lower left corner.
template <int kBits>
class TiledCells {
 public:
  static constexpr int kSide = 1 << kBits;

  TiledCells() = default;
  explicit TiledCells(const TileRect& rect) : rect_(rect) {}

  const TileRect& rect() const { return rect_; }
  /// The map's cell that is (0, 0) here.
  Cell origin() const { return {rect_.low.x * kSide, rect_.low.y * kSide}; }
  int columns() const { return rect_.width() * kSide; }  ///< cells
  int rows() const { return rect_.height() * kSide; }
  bool holds(int x, int y) const {
    return static_cast<unsigned>(x) < static_cast<unsigned>(columns()) &&
           static_cast<unsigned>(y) < static_cast<unsigned>(rows());
  }
  /// Which tile a cell is in; they count row by row.
  std::size_t slot(int x, int y) const {
    return static_cast<std::size_t>(y >> kBits) * static_cast<std::size_t>(rect_.width()) +
           static_cast<std::size_t>(x >> kBits);
  }
  TileIndex tile_index(std::size_t slot) const {
    const Cell first = corner(slot);
    return {rect_.low.x + (first.x >> kBits), rect_.low.y + (first.y >> kBits)};
  }
  /// The lower left cell of a tile.
  Cell corner(std::size_t slot) const {
    const auto width = static_cast<std::size_t>(rect_.width());
    return {static_cast<std::int32_t>(slot % width) * kSide, static_cast<std::int32_t>(slot / width) * kSide};
  }

 protected:
  TileRect rect_;
};

}  // namespace waymark::scan_matching
