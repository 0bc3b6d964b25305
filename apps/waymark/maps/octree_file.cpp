// SPDX-License-Identifier: Apache-2.0
#include "octree_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <sstream>

#include "plugins/shared/map_formats/octree_bytes.hpp"
#include "waymark/base/error.hpp"

namespace waymark::maps {

namespace {

constexpr int kMiddleKey = 32768;  // of the voxel whose lower corner is the map's origin

// Calling the template keeps its own debug output switched off.
using Tree = octomap::OccupancyOcTreeBase<octomap::OcTreeNode>;

}  // namespace

LoadedOctree read_octree(const std::filesystem::path& file) {
  const map_formats::OctreeBytes bytes = map_formats::OctreeBytes::read(file);
  bytes.check();
  LoadedOctree loaded;
  loaded.format = bytes.is_binary() ? map_formats::OctreeFormat::binary : map_formats::OctreeFormat::full;
  loaded.tree = std::make_unique<octomap::OcTree>(bytes.resolution_m());
  if (bytes.nodes() == 0) return loaded;
  std::istringstream in(bytes.content());
  in.seekg(static_cast<std::streamoff>(bytes.data_begin()));
  if (bytes.is_binary()) {
    loaded.tree->Tree::readBinaryData(in);
  } else {
    loaded.tree->Tree::readData(in);
  }
  if (!in || loaded.tree->size() != bytes.nodes())
    throw DataError(fmt::format("{}: liboctomap cannot read it", file.string()));
  return loaded;
}

VoxelBox box_of(const octomap::OcTree::leaf_iterator& leaf, const octomap::OcTree& tree) {
  const int side = 1 << (tree.getTreeDepth() - leaf.getDepth());
  const octomap::OcTreeKey key = leaf.getIndexKey();
  VoxelBox box{};
  for (unsigned axis = 0; axis < 3; ++axis) {
    box.low[axis] = static_cast<int>(key[axis]) - kMiddleKey;
    box.high[axis] = box.low[axis] + side;
  }
  return box;
}

OctreeFigures figures_of(const octomap::OcTree& tree) {
  OctreeFigures figures;
  std::array<int, 3> low{};
  std::array<int, 3> high{};
  low.fill(std::numeric_limits<int>::max());
  high.fill(std::numeric_limits<int>::min());
  for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf) {
    const VoxelBox box = box_of(leaf, tree);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], box.low[axis]);
      high[axis] = std::max(high[axis], box.high[axis]);
    }
    const auto side = static_cast<std::uint64_t>(box.high[0] - box.low[0]);
    (tree.isNodeOccupied(*leaf) ? figures.occupied : figures.free) += side * side * side;
    ++figures.leaves;
  }
  if (figures.leaves == 0) return figures;
  std::uint64_t all = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    figures.low_m[axis] = low[axis] * tree.getResolution();
    figures.high_m[axis] = high[axis] * tree.getResolution();
    all *= static_cast<std::uint64_t>(high[axis] - low[axis]);
  }
  figures.unknown = all - figures.occupied - figures.free;
  return figures;
}

}  // namespace waymark::maps
