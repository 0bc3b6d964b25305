// SPDX-License-Identifier: Apache-2.0
#include "map_modules/occupancy_grid/tile_window.hpp"

namespace waymark::occupancy_grid {

void TileWindow::open(const TileTree& tree, const Eigen::Vector2d& center, double reach, double resolution) {
  rect_ = scan_matching::TileRect::around(center.array() - reach, center.array() + reach, resolution * Tile::kSide);
  tiles_.resize(rect_.size());
  tree.gather(rect_, tiles_);
}

}  // namespace waymark::occupancy_grid
