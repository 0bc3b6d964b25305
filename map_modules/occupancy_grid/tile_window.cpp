// SPDX-License-Identifier: Apache-2.0
#include "map_modules/occupancy_grid/tile_window.hpp"

namespace waymark::occupancy_grid {

void TileWindow::open(const TileTree& tree, const Eigen::Vector2d& center, double reach, double resolution) {
  rect_ = scan_matching::TileRect::around(center.array() - reach, center.array() + reach, resolution * Tile::kSide);
  tiles_.resize(rect_.size());
  tree.gather(rect_, tiles_);
  odds_.resize(rect_.size());
  distances_.resize(rect_.size());
  for (std::size_t slot = 0; slot < tiles_.size(); ++slot) {
    odds_[slot] = tiles_[slot]->odds().data();
    distances_[slot] = tiles_[slot]->distances().data();
  }
}

}  // namespace waymark::occupancy_grid
