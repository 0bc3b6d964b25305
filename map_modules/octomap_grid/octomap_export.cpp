// SPDX-License-Identifier: Apache-2.0
// The way out: one octomap::OcTree of a whole map, which octovis and other programs read.
#include <fmt/format.h>

#include <bit>
#include <limits>
#include <string>
#include <utility>

#include "map_modules/octomap_grid/octomap_file.hpp"
#include "plugins/shared/map_formats/octree_text.hpp"
#include "waymark/base/error.hpp"

namespace waymark::octomap_grid {

namespace {

/// An octree into which leaves are put as they are.
class WholeOcTree final : public octomap::OcTree {
 public:
  explicit WholeOcTree(double voxel_m) : OcTree(voxel_m) {}

  /// A leaf of 2^level voxels in each direction around a voxel, which count from the map's origin.
  void add(Voxel at, int level, float odds) {
    const auto middle = static_cast<std::int32_t>(tree_max_val);
    for (const std::int32_t i : {at.x, at.y, at.z}) {
      if (i < -middle || i >= middle) {
        throw Error(fmt::format("the map reaches farther than the {} m from its origin that an OctoMap does",
                                tree_max_val * resolution));
      }
    }
    const std::uint32_t x = static_cast<std::uint32_t>(at.x + middle);
    const std::uint32_t y = static_cast<std::uint32_t>(at.y + middle);
    const std::uint32_t z = static_cast<std::uint32_t>(at.z + middle);
    if (root == nullptr) {
      root = new octomap::OcTreeNode;
      ++tree_size;
    }
    octomap::OcTreeNode* node = root;
    for (int bit = static_cast<int>(tree_depth) - 1; bit >= level; --bit) {
      const unsigned child = (x >> bit & 1u) | (y >> bit & 1u) << 1 | (z >> bit & 1u) << 2;
      node = nodeChildExists(node, child) ? getNodeChild(node, child) : createNodeChild(node, child);
    }
    // Zero is occupied for OctoMap, and free here.
    node->setLogOdds(odds == 0.0f ? -std::numeric_limits<float>::min() : odds);
    size_changed = true;
  }
};

}  // namespace

std::vector<MapFile> octomap_files(const VoxelMap& map, double resolution) {
  WholeOcTree tree(resolution);
  for_all_leaves(
      map, [&](Voxel at, int side, float odds) { tree.add(at, std::countr_zero(static_cast<unsigned>(side)), odds); });
  if (tree.size() == 0) return {};
  tree.updateInnerOccupancy();
  tree.prune();
  std::string full = map_formats::octree_text(tree, map_formats::OctreeFormat::full);
  return {{".bt", map_formats::octree_text(tree, map_formats::OctreeFormat::binary)}, {".ot", std::move(full)}};
}

}  // namespace waymark::octomap_grid
