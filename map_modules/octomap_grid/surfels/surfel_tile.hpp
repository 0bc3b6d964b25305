// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <set>
#include <span>
#include <vector>

#include "map_modules/octomap_grid/surfels/surfel.hpp"
#include "map_modules/shared/scan_matching/shared_tree.hpp"
#include "waymark/io/archive.hpp"

namespace waymark::octomap_grid {

/// Surfels over a square of 8 × 8 cells, at all heights, as a tile of a `SharedTree`.
class SurfelTile {
 public:
  static constexpr int kBits = 3;
  static constexpr int kSide = 1 << kBits;
  static constexpr std::size_t kColumns = std::size_t{kSide} * kSide;

  /// What one scan adds to a column of cells: surfels that are sorted by z.
  struct Addition {
    std::size_t column = 0;
    Surfel surfel;
  };

  /// Number of a column; only the last three bits of each count.
  static std::size_t column(std::int32_t x, std::int32_t y) {
    return static_cast<std::size_t>(y & (kSide - 1)) * kSide + static_cast<std::size_t>(x & (kSide - 1));
  }
  /// Null if there is none.
  const Surfel* find(std::size_t column, std::int32_t z) const {
    for (std::size_t i = begin_[column]; i < begin_[column + 1]; ++i) {
      if (surfels_[i].z == z) return &surfels_[i];
    }
    return nullptr;
  }
  /// True if `add` would change something.
  bool takes(std::span<const Addition> additions) const;
  /// Adds what a scan brings, sorted by column and z, to the cells that do not hold enough yet. `cell`: its side [m].
  void add(std::span<const Addition> additions, float cell);

  std::size_t size() const { return surfels_.size(); }
  std::span<const Surfel> surfels() const { return surfels_; }
  std::size_t bytes(std::set<const void*>& seen) const;
  void save(OutArchive& out) const;
  /// Throws DataError if what is read is not a valid tile.
  void load(InArchive& in);

 private:
  bool takes(const Addition& addition) const;

  std::array<std::uint32_t, kColumns + 1> begin_{};
  std::vector<Surfel> surfels_;  // column by column, from below
};

/// A particle's surfels of one size.
using SurfelTree = scan_matching::SharedTree<SurfelTile>;

}  // namespace waymark::octomap_grid
