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

  bool is_occupied(int x, int y) const { return Tile::is_occupied(odds(x, y)); }
  bool is_known(int x, int y) const { return Tile::is_known(odds(x, y)); }
  std::int8_t odds(int x, int y) const { return *odds_at(x, y); }
  std::uint8_t distance(int x, int y) const { return *distances_at(x, y); }
  /// A cell's value; those of the cells that follow it in the row of its tile follow.
  const std::int8_t* odds_at(int x, int y) const { return odds_[strip(x, y)] + Tile::place_in_strip(x, y); }
  const std::uint8_t* distances_at(int x, int y) const { return distances_[strip(x, y)] + Tile::place_in_strip(x, y); }

 protected:
  /// Which strip a cell is in; they count row by row through the window.
  std::size_t strip(int x, int y) const {
    return static_cast<std::size_t>(y >> Tile::kRowBits) * static_cast<std::size_t>(rect_.width()) +
           static_cast<std::size_t>(x >> Tile::kBits);
  }
  std::size_t strips() const { return rect_.size() * Tile::kStrips; }

  std::vector<const std::int8_t*> odds_;
  std::vector<const std::uint8_t*> distances_;

 private:
  std::vector<const Tile*> tiles_;  // scratch
};

/// The same for writing: the first write to a strip of a tile goes through the tree.
class WritableWindow : public TileWindow {
 public:
  void open_for_writing(TileTree& tree, const Eigen::Vector2d& center, double reach, double resolution) {
    open(tree, center, reach, resolution);
    tree_ = &tree;
    own_odds_.assign(strips(), nullptr);
    own_distances_.assign(strips(), nullptr);
  }
  std::int8_t* writable_odds_at(int x, int y) {
    const std::size_t at = strip(x, y);
    std::int8_t*& own = own_odds_[at];
    if (own == nullptr) odds_[at] = own = tile(x, y).odds.write_strip(strip_of_tile(y));
    return own + Tile::place_in_strip(x, y);
  }
  void set_distance(int x, int y, std::uint8_t distance) {
    const std::size_t at = strip(x, y);
    std::uint8_t*& own = own_distances_[at];
    if (own == nullptr) distances_[at] = own = tile(x, y).distances.write_strip(strip_of_tile(y));
    own[Tile::place_in_strip(x, y)] = distance;
  }

 private:
  Tile& tile(int x, int y) { return tree_->write(tile_index(slot(x, y))); }
  static std::size_t strip_of_tile(int y) { return static_cast<std::size_t>(y >> Tile::kRowBits) % Tile::kStrips; }

  TileTree* tree_ = nullptr;
  std::vector<std::int8_t*> own_odds_;
  std::vector<std::uint8_t*> own_distances_;
};

}  // namespace waymark::occupancy_grid
