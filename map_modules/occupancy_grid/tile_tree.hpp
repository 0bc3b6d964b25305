// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "shared_tree.hpp"
#include "tile.hpp"

namespace waymark::grid {

/// A particle's tiles.
using TileTree = SharedTree<Tile>;

/// What is nowhere written: all unknown, nothing near.
inline const Tile& empty_tile() { return TileTree::empty_tile(); }

}  // namespace waymark::grid
