// SPDX-License-Identifier: Apache-2.0
#include "map_modules/occupancy_grid/tile_window.hpp"

namespace waymark::occupancy_grid {

void TileWindow::open(const TileTree& tree, const Eigen::Vector2d& center, double reach, double resolution) {
  rect_ = scan_matching::TileRect::around(center.array() - reach, center.array() + reach, resolution * Tile::kSide);
  tiles_.resize(rect_.size());
  tree.gather(rect_, tiles_);
  // Most of the window is beyond what was ever seen, and all strips of an empty tile are the same.
  const Tile& empty = TileTree::empty_tile();
  odds_.assign(strips(), empty.odds.strip(0));
  distances_.assign(strips(), empty.distances.strip(0));
  const auto width = static_cast<std::size_t>(rect_.width());
  for (std::size_t row = 0, slot = 0; slot < tiles_.size(); ++row) {
    for (std::size_t column = 0; column < width; ++column, ++slot) {
      const Tile& tile = *tiles_[slot];
      if (&tile == &empty) continue;
      for (std::size_t i = 0; i < Tile::kStrips; ++i) {
        const std::size_t at = (row * Tile::kStrips + i) * width + column;
        odds_[at] = tile.odds.strip(i);
        distances_[at] = tile.distances.strip(i);
      }
    }
  }
}

}  // namespace waymark::occupancy_grid
