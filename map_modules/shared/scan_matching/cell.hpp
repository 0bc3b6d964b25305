// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>

namespace waymark::scan_matching {

/// A cell, counted from the map's origin: cell (0, 0) has its lower left corner there.
struct Cell {
  std::int32_t x = 0;
  std::int32_t y = 0;

  bool operator==(const Cell&) const = default;
};

/// Where a tile lies, counted in tiles.
struct TileIndex {
  /// Tiles may lie this far from the origin, so that their cells still have 32 bits.
  static constexpr std::int32_t kMost = 30'000'000;

  std::int32_t x = 0;
  std::int32_t y = 0;

  bool operator==(const TileIndex&) const = default;
};

/// A rectangle of tiles; `high` belongs to it.
struct TileRect {
  TileIndex low;
  TileIndex high;

  int width() const { return high.x - low.x + 1; }
  int height() const { return high.y - low.y + 1; }
  std::size_t size() const { return static_cast<std::size_t>(width()) * static_cast<std::size_t>(height()); }

  /// All tiles with sides of `side` [m] from `low` to `high` [m]. Throws Error if that is not a place for cells of 32
  /// bits.
  static TileRect around(const Eigen::Vector2d& low, const Eigen::Vector2d& high, double side);
};

/// Throws DataError if the cells of a checkpoint's map have another size than `resolution_m` [m].
void require_resolution(double found, double expected);

/// Writes the size of the cells [m], or reads one and requires it to be equal.
template <class Archive>
void serialize_resolution(Archive& archive, double resolution) {
  double stored = resolution;
  archive(stored);
  if constexpr (Archive::kReads) require_resolution(stored, resolution);
}

}  // namespace waymark::scan_matching
