// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>

#include "map_modules/occupancy_grid/tile_tree.hpp"
#include "waymark/interface/particle_map.hpp"

namespace waymark::occupancy_grid {

/// Sums over a whole map.
struct GridFigures {
  std::size_t occupied = 0;  ///< cells
  std::size_t free = 0;
  double mean_entropy_bit = 0.0;  ///< of the known cells: 0 is a crisp map, 1 is no information
  std::size_t tiles = 0;
  std::size_t tiles_shared = 0;  ///< with other particles
};

GridFigures figures_of(const TileTree& tiles);

/// The known cells as a picture for sinks; absent if nothing is known. Throws Error if the rectangle around them is too
/// large to be one picture.
std::optional<GridView> view_of(const TileTree& tiles, double resolution);

}  // namespace waymark::occupancy_grid
