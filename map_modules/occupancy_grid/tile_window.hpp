// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "map_modules/occupancy_grid/tile_tree.hpp"
#include "map_modules/shared/scan_matching/tiled_cells.hpp"

namespace waymark::occupancy_grid {

/// The tiles around one scan, side by side, so that a cell is found without the tree. Cells count from the window's own
/// lower left corner here. Kept from scan to scan for its storage.
class TileWindow : public scan_matching::TiledCells<Tile::kBits> {
 public:
  /// Looks at all tiles within `reach` [m] of `center` [m]. Throws Error if that is not a place for cells of 32 bits.
  void open(const TileTree& tree, const Eigen::Vector2d& center, double reach, double resolution);

  const Tile& tile(std::size_t slot) const { return *tiles_[slot]; }
  /// Distances of a tile, row by row.
  const std::uint8_t* distances(std::size_t slot) const { return tiles_[slot]->distance.data(); }
  bool is_occupied(int x, int y) const { return Tile::is_occupied(odds(x, y)); }
  bool is_known(int x, int y) const { return Tile::is_known(odds(x, y)); }
  std::int8_t odds(int x, int y) const { return tiles_[slot(x, y)]->odds[Tile::place(x, y)]; }
  std::uint8_t distance(int x, int y) const { return tiles_[slot(x, y)]->distance[Tile::place(x, y)]; }

 protected:
  std::vector<const Tile*> tiles_;
};

/// The same for writing: the first write to a tile goes through the tree.
class WritableWindow : public TileWindow {
 public:
  void open_for_writing(TileTree& tree, const Eigen::Vector2d& center, double reach, double resolution) {
    open(tree, center, reach, resolution);
    tree_ = &tree;
    own_.assign(rect_.size(), nullptr);
  }
  Tile& writable(std::size_t slot) {
    if (own_[slot] == nullptr) {
      own_[slot] = &tree_->write(tile_index(slot));
      tiles_[slot] = own_[slot];
    }
    return *own_[slot];
  }
  void set_distance(int x, int y, std::uint8_t distance) {
    writable(slot(x, y)).distance[Tile::place(x, y)] = distance;
  }

 private:
  TileTree* tree_ = nullptr;
  std::vector<Tile*> own_;
};

}  // namespace waymark::occupancy_grid
