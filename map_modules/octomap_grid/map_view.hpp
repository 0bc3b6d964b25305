// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>

#include "map_modules/octomap_grid/octomap_grid_settings.hpp"
#include "map_modules/octomap_grid/voxel_tile.hpp"
#include "waymark/interface/particle_map.hpp"

namespace waymark::octomap_grid {

/// Sums over a whole map.
struct MapFigures {
  std::size_t occupied = 0;  ///< voxels
  std::size_t free = 0;
  double mean_entropy_bit = 0.0;  ///< of the known voxels: 0 is a crisp map, 1 is no information
  std::size_t nodes = 0;          ///< of the octrees
  std::size_t tiles = 0;
  std::size_t tiles_shared = 0;  ///< with other particles
};

MapFigures figures_of(const VoxelMap& map);

/// The layers whose middles lie in `slice`, seen from above: the largest probability over them. Absent if nothing is
/// known there. Throws Error if the rectangle around it is too large to be one picture.
std::optional<GridView> slice_of(const VoxelMap& map, double resolution, const Heights& slice);

}  // namespace waymark::octomap_grid
