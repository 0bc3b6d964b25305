// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <set>
#include <vector>

#include "map_modules/octomap_grid/voxel_octree.hpp"
#include "map_modules/shared/scan_matching/distance_field.hpp"
#include "map_modules/shared/scan_matching/shared_tree.hpp"
#include "waymark/memory/cow.hpp"

namespace waymark::octomap_grid {

using scan_matching::Cell;
using scan_matching::TileIndex;
using scan_matching::TileRect;

/// A voxel, counted from the map's origin: voxel (0, 0, 0) has its lowest corner there.
struct Voxel {
  std::int32_t x = 0;
  std::int32_t y = 0;
  std::int32_t z = 0;

  bool operator==(const Voxel&) const = default;
  auto operator<=>(const Voxel&) const = default;
};

/// One layer of a tile, for matching: a match moves in x, y and yaw, so what counts is the distance within the layer.
struct Slab {
  static constexpr int kSide = VoxelOctree::kSide;

  std::array<std::uint8_t, std::size_t{kSide} * kSide> distance;
  std::array<std::uint16_t, kSide> occupied{};  ///< one bit a voxel; the octree has it, too, but is slower

  Slab() { distance.fill(scan_matching::StoredDistance::kFar); }
  static std::size_t place(std::int32_t x, std::int32_t y) {
    return static_cast<std::size_t>(y & (kSide - 1)) * kSide + static_cast<std::size_t>(x & (kSide - 1));
  }
  bool is_occupied(std::int32_t x, std::int32_t y) const {
    return (occupied[static_cast<std::size_t>(y & (kSide - 1))] >> (x & (kSide - 1)) & 1) != 0;
  }
  void set_occupied(std::int32_t x, std::int32_t y, bool is) {
    auto& row = occupied[static_cast<std::size_t>(y & (kSide - 1))];
    const auto bit = static_cast<std::uint16_t>(1 << (x & (kSide - 1)));
    row = static_cast<std::uint16_t>(is ? row | bit : row & ~bit);
  }
};

/// The layers of one cube of which something is kept. Each is shared by itself.
class Layers {
 public:
  Layers() { slab_of_.fill(kNone); }

  /// The slab of a layer, 0 … kSide − 1; null if nothing occupied is near.
  const Slab* find(std::int32_t z) const {
    const std::int8_t at = slab_of_[static_cast<std::size_t>(z & (VoxelOctree::kSide - 1))];
    return at == kNone ? nullptr : &slabs_[static_cast<std::size_t>(at)].read();
  }
  /// The same for writing: cloned first if others share it, made if it is not there.
  Slab& write(std::int32_t z);

  std::size_t bytes(std::set<const void*>& seen) const;
  void save(OutArchive& out) const;
  /// Throws DataError if what is read are not valid layers.
  void load(InArchive& in);

 private:
  static constexpr std::int8_t kNone = -1;
  std::array<std::int8_t, VoxelOctree::kSide> slab_of_;
  std::vector<Cow<Slab>> slabs_;
};

/// A cube of voxels: occupancy as an octree, and distances of those layers where something occupied is within reach.
/// Copies share what either holds, and a write clones only the brick or the layer that it changes.
class VoxelTile {
 public:
  VoxelOctree voxels;

  /// The slab of a layer, 0 … kSide − 1; null if nothing occupied is near.
  const Slab* slab(std::int32_t z) const { return layers_ ? layers_->read().find(z) : nullptr; }
  /// The same for writing: cloned first if others share it, made if it is not there. Stays where it is until the tile
  /// is copied.
  Slab& write_slab(std::int32_t z);

  std::size_t bytes(std::set<const void*>& seen) const;
  void save(OutArchive& out) const;
  /// Throws DataError if what is read is not a valid tile.
  void load(InArchive& in);

 private:
  std::optional<Cow<Layers>> layers_;  // most cubes have none
};

/// The tiles above one another. Robots go far, but not high: the tree that particles share branches in the plane.
class TileColumn {
 public:
  /// Null if nothing is written there; `z` counts tiles.
  const VoxelTile* find(std::int32_t z) const;
  /// For writing: cloned first if others share it, made if it is not there. Stays where it is until the column is
  /// copied.
  VoxelTile& write(std::int32_t z);
  /// Calls visit(z, tile, is_shared), from below.
  template <class Visit>
  void for_all(const Visit& visit) const {
    for (const Placed& placed : tiles_) visit(placed.z, placed.tile.read(), placed.tile.is_shared());
  }

  std::size_t bytes(std::set<const void*>& seen) const;
  void save(OutArchive& out) const;
  void load(InArchive& in);

 private:
  struct Placed {
    std::int32_t z;
    Cow<VoxelTile> tile;
  };
  std::vector<Placed> tiles_;  // from below
};

/// A particle's map.
using VoxelMap = scan_matching::SharedTree<TileColumn>;

/// Where tiles lie, counted in tiles.
inline std::int32_t tile_of(std::int32_t voxel) { return voxel >> VoxelOctree::kBits; }

/// Calls visit(Voxel of the lowest corner, side in voxels, log-odds) for all leaves of the map, in a fixed order.
template <class Visit>
void for_all_leaves(const VoxelMap& map, const Visit& visit) {
  map.for_all([&](TileIndex index, const TileColumn& column, bool) {
    column.for_all([&](std::int32_t z, const VoxelTile& tile, bool) {
      tile.voxels.for_all([&](LocalVoxel v, int side, float odds) {
        constexpr int kSide = VoxelOctree::kSide;
        visit(Voxel{index.x * kSide + v.x, index.y * kSide + v.y, z * kSide + v.z}, side, odds);
      });
    });
  });
}

}  // namespace waymark::octomap_grid
