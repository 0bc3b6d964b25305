// SPDX-License-Identifier: Apache-2.0
#include "tile_window.hpp"

#include <cmath>

#include "waymark/error.hpp"

namespace waymark::grid {

void TileWindow::open(const TileTree& tree, const Eigen::Vector2d& center, double reach, double resolution) {
  const double side = resolution * Tile::kSide;
  const Eigen::Vector2d low = (center.array() - reach) / side;
  const Eigen::Vector2d high = (center.array() + reach) / side;
  constexpr double kMost = TileTree::kMaxIndex;
  if (!(low.minCoeff() > -kMost && high.maxCoeff() < kMost)) {  // NaN, too
    throw Error("the scan lies outside of what a grid can hold");
  }
  const auto index = [](double tiles) { return static_cast<std::int32_t>(std::floor(tiles)); };
  rect_ = {{index(low.x()), index(low.y())}, {index(high.x()), index(high.y())}};
  tiles_.resize(rect_.size());
  tree.gather(rect_, tiles_);
}

}  // namespace waymark::grid
