// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <utility>
#include <vector>

#include "map_modules/octomap_grid/voxel_tile.hpp"
#include "map_modules/shared/scan_matching/tiled_cells.hpp"

namespace waymark::octomap_grid {

/// The columns around one scan, for writing: the first write to a column goes through the tree.
class ColumnWindow : public scan_matching::TiledCells<VoxelOctree::kBits> {
 public:
  /// Throws Error if that is not a place for a map. [m]
  void open(VoxelMap& map, const Eigen::Vector2d& low, const Eigen::Vector2d& high, double resolution);

  const TileColumn& column(std::size_t slot) const { return *columns_[slot]; }
  TileColumn& writable(std::size_t slot);

 private:
  VoxelMap* map_ = nullptr;
  std::vector<const TileColumn*> columns_;
  std::vector<TileColumn*> own_;
};

/// One layer of a map, as `scan_matching::update_distances` needs it. Voxels count from the corner of the window.
class LayerWindow {
 public:
  void open(ColumnWindow& columns, std::int32_t z);

  bool is_occupied(int x, int y) { return slab(slot(x, y)).is_occupied(x, y); }
  std::uint8_t distance(int x, int y) { return slab(slot(x, y)).distance[Slab::place(x, y)]; }
  void set_distance(int x, int y, std::uint8_t distance);

 private:
  std::size_t slot(int x, int y) const { return columns_->slot(x, y); }
  const Slab& slab(std::size_t slot) { return slabs_[slot] == nullptr ? find(slot) : *slabs_[slot]; }
  const Slab& find(std::size_t slot);

  ColumnWindow* columns_ = nullptr;
  std::int32_t z_ = 0;
  std::vector<const Slab*> slabs_;  // per column; null: not looked at yet
  std::vector<Slab*> own_;          // those that may be written
};

/// A voxel: its layer, and where in the window it is.
using LayerCell = std::pair<std::int32_t, Cell>;

/// Brings distances up to date where voxels became occupied or free. Holds the storage that this takes.
class DistanceUpdate {
 public:
  /// What changed, in voxels of the window, which must reach 2 · `StoredDistance::kReach` voxels beyond; sorts both.
  void apply(ColumnWindow& window, std::vector<LayerCell>& freed, std::vector<LayerCell>& occupied);

 private:
  LayerWindow layer_;
  std::vector<Cell> freed_;
  std::vector<Cell> occupied_;
};

}  // namespace waymark::octomap_grid
