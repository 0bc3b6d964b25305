// SPDX-License-Identifier: Apache-2.0
#include "tile_window.hpp"

namespace waymark::grid {

void TileWindow::open(const TileTree& tree, const Eigen::Vector2d& center, double reach, double resolution) {
  rect_ = TileRect::around(center.array() - reach, center.array() + reach, resolution * Tile::kSide);
  tiles_.resize(rect_.size());
  tree.gather(rect_, tiles_);
}

}  // namespace waymark::grid
