// SPDX-License-Identifier: Apache-2.0
#include "conversion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "octree_file.hpp"
#include "plugins/shared/map_formats/grid_extent.hpp"
#include "waymark/base/error.hpp"

namespace waymark::maps {

namespace {

constexpr int kHalfKeys = 32768;  // voxels from the middle of an octree to its ends
// A few bytes may claim a cube of kilometres: a grid takes no more cells than these, or than these for each node.
constexpr std::int64_t kCellsOfAnyTree = std::int64_t{1} << 24;
constexpr std::int64_t kCellsPerNode = 4096;
constexpr std::uint8_t kFreePercent = 0;
constexpr std::uint8_t kOccupiedPercent = 100;

/// Layers from `first` up to, not including, `end`.
struct Layers {
  int first;
  int end;
};

Layers layers_of(const Slice& slice, double resolution) {
  // The middle of layer k is (k + ½) · resolution.
  const auto beyond = [&](double height) {
    return static_cast<int>(std::clamp(std::ceil(height / resolution - 0.5), -1.0 * kHalfKeys, 1.0 * kHalfKeys));
  };
  const Layers layers{beyond(slice.low_m), beyond(slice.high_m)};
  if (layers.first >= layers.end) {
    throw Error(fmt::format("--slice-m {},{}: no voxel has its middle there; layers are {} m high", slice.low_m,
                            slice.high_m, resolution));
  }
  return layers;
}

template <class Visit>
void for_leaves_in(const octomap::OcTree& tree, const Layers& layers, const Visit& visit) {
  for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf) {
    const VoxelBox box = box_of(leaf, tree);
    if (box.high[2] > layers.first && box.low[2] < layers.end) visit(box, tree.isNodeOccupied(*leaf));
  }
}

}  // namespace

GridView slice_of(const octomap::OcTree& tree, const Slice& slice) {
  const double resolution = tree.getResolution();
  const Layers layers = layers_of(slice, resolution);
  map_formats::GridExtent extent;
  for_leaves_in(tree, layers,
                [&](const VoxelBox& box, bool) { extent.add(box.low[0], box.low[1], box.high[0] - box.low[0]); });
  if (extent.empty())
    throw Error(fmt::format("--slice-m {},{}: nothing is known between these heights", slice.low_m, slice.high_m));
  const std::int64_t most = std::max(kCellsOfAnyTree, kCellsPerNode * static_cast<std::int64_t>(tree.size()));
  if (extent.cells() > most) {
    throw Error(fmt::format("--slice-m {},{}: {} cells are too many for an octree of {} nodes; at most {} are expected",
                            slice.low_m, slice.high_m, extent.cells(), tree.size(), most));
  }
  GridView grid = extent.unknown(resolution);
  for_leaves_in(tree, layers, [&](const VoxelBox& box, bool occupied) {
    for (int y = box.low[1]; y < box.high[1]; ++y) {
      for (int x = box.low[0]; x < box.high[0]; ++x) {
        std::uint8_t& cell = grid.cells[extent.place(x, y)];
        if (occupied) {
          cell = kOccupiedPercent;
        } else if (cell == GridView::kUnknown) {
          cell = kFreePercent;
        }
      }
    }
  });
  return grid;
}

std::unique_ptr<octomap::OcTree> layer_of(const GridView& grid) {
  const double yaw = grid.T_map_grid.yaw();
  if (yaw != 0.0) throw Error(fmt::format("origin: the third number, the yaw, is {}; an octree cannot be turned", yaw));
  const auto first_of = [&](double corner_m) { return std::round(corner_m / grid.resolution_m); };
  const double first_x = first_of(grid.T_map_grid.p.x());
  const double first_y = first_of(grid.T_map_grid.p.y());
  for (const double end : {first_x, first_y, first_x + grid.width - 1, first_y + grid.height - 1}) {
    if (end >= -kHalfKeys && end < kHalfKeys) continue;
    throw Error(fmt::format("the grid ends {} cells from the map's origin; an octree has {} each way", std::abs(end),
                            kHalfKeys));
  }
  auto tree = std::make_unique<octomap::OcTree>(grid.resolution_m);
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const std::uint8_t percent =
          grid.cells[static_cast<std::size_t>(y) * static_cast<std::size_t>(grid.width) + static_cast<std::size_t>(x)];
      if (percent == GridView::kUnknown || percent == 50) continue;
      const octomap::OcTreeKey key(static_cast<octomap::key_type>(static_cast<int>(first_x) + x + kHalfKeys),
                                   static_cast<octomap::key_type>(static_cast<int>(first_y) + y + kHalfKeys),
                                   static_cast<octomap::key_type>(kHalfKeys));
      const float odds = percent > 50 ? tree->getClampingThresMaxLog() : tree->getClampingThresMinLog();
      tree->setNodeValue(key, odds, true);
    }
  }
  tree->updateInnerOccupancy();
  tree->prune();
  return tree;
}

}  // namespace waymark::maps
