// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "map_modules/occupancy_grid/tile.hpp"
#include "map_modules/shared/scan_matching/shared_tree.hpp"

namespace waymark::occupancy_grid {

/// A particle's tiles.
using TileTree = scan_matching::SharedTree<Tile>;

/// The tile of places that were never written: all unknown, nothing near.
inline const Tile& empty_tile() { return TileTree::empty_tile(); }

}  // namespace waymark::occupancy_grid
