// SPDX-License-Identifier: Apache-2.0
#include "map_view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "waymark/error.hpp"

namespace waymark::octo {

namespace {

constexpr std::int64_t kMostCells = std::int64_t{1} << 30;

double probability(float odds) { return 1.0 / (1.0 + std::exp(-static_cast<double>(odds))); }

double entropy_bit(double p) { return -(p * std::log2(p) + (1.0 - p) * std::log2(1.0 - p)); }

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
        (VoxelOctree::is_occupied(odds) ? figures.occupied : figures.free) += voxels;
        entropy += static_cast<double>(voxels) * entropy_bit(probability(odds));
      });
    });
  });
  const std::size_t known = figures.occupied + figures.free;
  if (known > 0) figures.mean_entropy_bit = entropy / static_cast<double>(known);
  return figures;
}

std::optional<GridView> slice_of(const VoxelMap& map, double resolution, const Heights& slice) {
  constexpr std::int32_t kMost = std::numeric_limits<std::int32_t>::max();
  Cell low{kMost, kMost};
  Cell high{-kMost, -kMost};
  const auto in_slice = [&](std::int32_t z, int side) {
    for (int i = 0; i < side; ++i) {
      if (slice.hold((z + i + 0.5) * resolution)) return true;
    }
    return false;
  };
  for_all_leaves(map, [&](Voxel v, int side, float) {
    if (!in_slice(v.z, side)) return;
    low = {std::min(low.x, v.x), std::min(low.y, v.y)};
    high = {std::max(high.x, v.x + side - 1), std::max(high.y, v.y + side - 1)};
  });
  if (low.x > high.x) return std::nullopt;
  const std::int64_t width = std::int64_t{high.x} - low.x + 1;
  const std::int64_t height = std::int64_t{high.y} - low.y + 1;
  if (width > kMostCells / height) throw Error(fmt::format("a grid of {} x {} cells is no picture", width, height));
  GridView view;
  view.T_map_grid = Pose::planar(low.x * resolution, low.y * resolution, 0.0);
  view.resolution_m = resolution;
  view.width = static_cast<int>(width);
  view.height = static_cast<int>(height);
  view.cells.assign(static_cast<std::size_t>(width * height), GridView::kUnknown);
  for_all_leaves(map, [&](Voxel v, int side, float odds) {
    if (!in_slice(v.z, side)) return;
    const auto percent = static_cast<std::uint8_t>(std::lround(100.0 * probability(odds)));
    for (std::int32_t y = v.y; y < v.y + side; ++y) {
      for (std::int32_t x = v.x; x < v.x + side; ++x) {
        std::uint8_t& cell = view.cells[static_cast<std::size_t>((y - low.y) * width + (x - low.x))];
        cell = cell == GridView::kUnknown ? percent : std::max(cell, percent);
      }
    }
  });
  return view;
}

}  // namespace waymark::octo
