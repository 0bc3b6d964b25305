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

  /// Of a tile, row by row.
  const std::int8_t* odds(std::size_t slot) const { return odds_[slot]; }
  const std::uint8_t* distances(std::size_t slot) const { return distances_[slot]; }
  bool is_occupied(int x, int y) const { return Tile::is_occupied(odds(x, y)); }
  bool is_known(int x, int y) const { return Tile::is_known(odds(x, y)); }
  std::int8_t odds(int x, int y) const { return odds_[slot(x, y)][Tile::place(x, y)]; }
  std::uint8_t distance(int x, int y) const { return distances_[slot(x, y)][Tile::place(x, y)]; }

 protected:
  std::vector<const std::int8_t*> odds_;
  std::vector<const std::uint8_t*> distances_;

 private:
  std::vector<const Tile*> tiles_;  // scratch
};

/// The same for writing: the first write to a part of a tile goes through the tree.
class WritableWindow : public TileWindow {
 public:
  void open_for_writing(TileTree& tree, const Eigen::Vector2d& center, double reach, double resolution) {
    open(tree, center, reach, resolution);
    tree_ = &tree;
    own_odds_.assign(rect_.size(), nullptr);
    own_distances_.assign(rect_.size(), nullptr);
  }
  std::int8_t* writable_odds(std::size_t slot) {
    std::int8_t*& own = own_odds_[slot];
    if (own == nullptr) odds_[slot] = own = tree_->write(tile_index(slot)).write_odds().data();
    return own;
  }
  void set_distance(int x, int y, std::uint8_t distance) {
    const std::size_t at = slot(x, y);
    std::uint8_t*& own = own_distances_[at];
    if (own == nullptr) distances_[at] = own = tree_->write(tile_index(at)).write_distances().data();
    own[Tile::place(x, y)] = distance;
  }

 private:
  TileTree* tree_ = nullptr;
  std::vector<std::int8_t*> own_odds_;
  std::vector<std::uint8_t*> own_distances_;
};

}  // namespace waymark::occupancy_grid
