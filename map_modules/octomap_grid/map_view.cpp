// SPDX-License-Identifier: Apache-2.0
#include "map_modules/octomap_grid/map_view.hpp"

#include <algorithm>
#include <cmath>

#include "map_modules/shared/scan_matching/cell_entropy.hpp"
#include "plugins/shared/map_formats/grid_extent.hpp"

namespace waymark::octomap_grid {

namespace {

double probability(float odds) { return 1.0 / (1.0 + std::exp(-static_cast<double>(odds))); }

}  // namespace

MapFigures figures_of(const VoxelMap& map) {
  MapFigures figures;
  double entropy = 0.0;
  map.for_all([&](TileIndex, const TileColumn& column, bool column_is_shared) {
    column.for_all([&](std::int32_t, const VoxelTile& tile, bool is_shared) {
      ++figures.tiles;
      figures.tiles_shared += column_is_shared || is_shared;
      figures.nodes += tile.voxels.nodes();
      tile.voxels.for_all([&](LocalVoxel, int side, float odds) {
        const auto voxels = static_cast<std::size_t>(side) * static_cast<std::size_t>(side * side);
        (is_occupied(odds) ? figures.occupied : figures.free) += voxels;
        entropy += static_cast<double>(voxels) * scan_matching::entropy_bit(probability(odds));
      });
    });
  });
  const std::size_t known = figures.occupied + figures.free;
  if (known > 0) figures.mean_entropy_bit = entropy / static_cast<double>(known);
  return figures;
}

std::optional<GridView> slice_of(const VoxelMap& map, double resolution, const Heights& slice) {
  const auto in_slice = [&](std::int32_t z, int side) {
    for (int i = 0; i < side; ++i) {
      if (slice.hold((z + i + 0.5) * resolution)) return true;
    }
    return false;
  };
  map_formats::GridExtent extent;
  for_all_leaves(map, [&](Voxel v, int side, float) {
    if (in_slice(v.z, side)) extent.add(v.x, v.y, side);
  });
  if (extent.empty()) return std::nullopt;
  GridView view = extent.unknown(resolution);
  for_all_leaves(map, [&](Voxel v, int side, float odds) {
    if (!in_slice(v.z, side)) return;
    const auto percent = static_cast<std::uint8_t>(std::lround(100.0 * probability(odds)));
    for (std::int32_t y = v.y; y < v.y + side; ++y) {
      for (std::int32_t x = v.x; x < v.x + side; ++x) {
        std::uint8_t& cell = view.cells[extent.place(x, y)];
        cell = cell == GridView::kUnknown ? percent : std::max(cell, percent);
      }
    }
  });
  return view;
}

}  // namespace waymark::octomap_grid
