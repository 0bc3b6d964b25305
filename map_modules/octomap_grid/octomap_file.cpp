// SPDX-License-Identifier: Apache-2.0
#include "map_modules/octomap_grid/octomap_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "map_modules/octomap_grid/column_window.hpp"
#include "plugins/shared/map_formats/octree_bytes.hpp"
#include "waymark/base/error.hpp"

namespace waymark::octomap_grid {

namespace {

constexpr std::size_t kMostNodes = std::size_t{1} << 28;
constexpr std::size_t kMostTiles = std::size_t{1} << 20;
// A few bytes may claim a cube of kilometres. In maps of rooms and streets a cube takes bytes, not the reverse.
constexpr std::size_t kTilesOfAnyFile = 1024;
constexpr std::size_t kTilesPerByte = 16;

class Reader {
 public:
  Reader(const map_formats::OctreeBytes& bytes, const OctomapGridSettings& settings)
      : bytes_(bytes), odds_(settings.odds), resolution_(settings.resolution) {}

  VoxelMap read() {
    if (std::abs(bytes_.resolution_m() - resolution_) > 1e-9)
      bytes_.fail(fmt::format("its voxels have {} m, but resolution_m is {}", bytes_.resolution_m(), resolution_));
    if (bytes_.nodes() > kMostNodes)
      bytes_.fail(fmt::format("{} nodes; a map has at most {}", bytes_.nodes(), kMostNodes));
    bytes_.for_leaves([&](const map_formats::OctreeLeaf& leaf) {
      const Voxel corner{leaf.low[0], leaf.low[1], leaf.low[2]};
      const float of_binary = 0.5f * (leaf.is_occupied ? odds_.high : odds_.low);
      add_leaf(leaf.level, corner, bytes_.is_binary() ? of_binary : std::clamp(leaf.odds, odds_.low, odds_.high));
    });
    put_tile();
    return std::move(map_);
  }

 private:
  void add_leaf(int level, Voxel corner, float odds) {
    constexpr int kBits = VoxelOctree::kBits;
    const std::int32_t tiles = level > kBits ? 1 << (level - kBits) : 1;
    const auto count =
        static_cast<std::size_t>(tiles) * static_cast<std::size_t>(tiles) * static_cast<std::size_t>(tiles);
    if (level > kBits) room_for(count);
    for (std::int32_t y = 0; y < tiles; ++y) {
      for (std::int32_t x = 0; x < tiles; ++x) {
        for (std::int32_t z = 0; z < tiles; ++z) {
          VoxelOctree::Draft& tile = tile_at({tile_of(corner.x) + x, tile_of(corner.y) + y}, tile_of(corner.z) + z);
          constexpr std::int32_t kLast = VoxelOctree::kSide - 1;
          const LocalVoxel at{static_cast<std::uint8_t>(corner.x & kLast), static_cast<std::uint8_t>(corner.y & kLast),
                              static_cast<std::uint8_t>(corner.z & kLast)};
          tile.set(at, std::min(level, kBits), odds);
        }
      }
    }
  }

  /// Leaves come in the octree's order, so those of one tile come one after the other.
  VoxelOctree::Draft& tile_at(TileIndex index, std::int32_t z) {
    if (tiles_ == 0 || index != index_ || z != z_) {
      put_tile();
      room_for(1);
      ++tiles_;
      index_ = index;
      z_ = z;
    }
    return tile_;
  }
  /// The tile whose leaves were read last.
  void put_tile() {
    if (tiles_ == 0) return;
    map_.write(index_).write(z_).voxels = VoxelOctree(tile_);
    tile_.known.fill(0);
  }
  void room_for(std::size_t more) const {
    const std::size_t size = bytes_.content().size();
    const std::size_t most = std::min(kMostTiles, kTilesOfAnyFile + kTilesPerByte * size);
    if (tiles_ + more > most) {
      bytes_.fail(
          fmt::format("the map fills more than {} cubes of {} voxels, the most that {}", most, VoxelOctree::kVoxels,
                      most == kMostTiles ? "a map can have" : fmt::format("a file of {} bytes may hold", size)));
    }
  }

  const map_formats::OctreeBytes& bytes_;
  VoxelOdds odds_;
  double resolution_;
  VoxelMap map_;
  std::size_t tiles_ = 0;
  VoxelOctree::Draft tile_;  // the last of them
  TileIndex index_;
  std::int32_t z_ = 0;
};

/// Distances of a map of which only the odds are known, column by column.
void compute_distances(VoxelMap& map) {
  constexpr std::int32_t kSide = VoxelOctree::kSide;
  std::vector<TileIndex> columns;
  map.for_all([&](TileIndex index, const TileColumn&, bool) { columns.push_back(index); });
  ColumnWindow window;
  DistanceUpdate update;
  std::vector<LayerCell> none;
  std::vector<LayerCell> occupied;
  for (const TileIndex index : columns) {
    const Eigen::Vector2d corner(index.x * kSide, index.y * kSide);  // in voxels
    window.open(map, corner.array() - kSide, corner.array() + 1.5 * kSide, 1.0);
    const Cell from{index.x * kSide - window.origin().x, index.y * kSide - window.origin().y};
    const std::size_t slot = window.slot(from.x, from.y);
    occupied.clear();
    window.column(slot).for_all([&](std::int32_t z, const VoxelTile& tile, bool) {
      tile.voxels.for_all([&](LocalVoxel v, int side, float odds) {
        if (!is_occupied(odds)) return;
        for (int i = 0; i < side * side * side; ++i) {
          const Cell at{from.x + v.x + i % side, from.y + v.y + i / side % side};
          occupied.emplace_back(z * kSide + v.z + i / (side * side), at);
        }
      });
    });
    if (occupied.empty()) continue;
    TileColumn& column = window.writable(slot);
    for (const auto& [z, at] : occupied)
      column.write(tile_of(z)).write_slab(z).set_occupied(at.x - from.x, at.y - from.y, true);
    update.apply(window, none, occupied);
  }
}

}  // namespace

VoxelMap load_octomap(const std::filesystem::path& file, const OctomapGridSettings& settings) {
  VoxelMap map = Reader(map_formats::OctreeBytes::read(file), settings).read();
  compute_distances(map);
  return map;
}

}  // namespace waymark::octomap_grid
