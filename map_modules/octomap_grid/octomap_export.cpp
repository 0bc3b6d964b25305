// SPDX-License-Identifier: Apache-2.0
// The way out: one octomap::OcTree of a whole map, which octovis and other programs read.
#include <fmt/format.h>
#include <octomap/OcTree.h>

#include <sstream>
#include <string>
#include <string_view>

#include "octomap_file.hpp"
#include "waymark/error.hpp"

namespace waymark::octo {

namespace {

/// An octree into which tiles are put as a whole.
class WholeOcTree final : public octomap::OcTree {
 public:
  explicit WholeOcTree(double voxel_m) : OcTree(voxel_m) {}

  /// Tiles count from the map's origin.
  void add(TileIndex index, std::int32_t z, const VoxelOctree& tile) {
    const auto middle = static_cast<std::int32_t>(tree_max_val) >> VoxelOctree::kBits;
    for (const std::int32_t i : {index.x, index.y, z}) {
      if (i < -middle || i >= middle) {
        throw Error(fmt::format("the map reaches farther than the {} m from its origin that an OctoMap does",
                                tree_max_val * resolution));
      }
    }
    const std::uint32_t x = static_cast<std::uint32_t>(index.x + middle);
    const std::uint32_t y = static_cast<std::uint32_t>(index.y + middle);
    const std::uint32_t up = static_cast<std::uint32_t>(z + middle);
    if (root == nullptr) {
      root = new octomap::OcTreeNode;
      ++tree_size;
    }
    octomap::OcTreeNode* node = root;
    for (int bit = static_cast<int>(tree_depth) - VoxelOctree::kBits - 1; bit >= 0; --bit) {
      const unsigned child = (x >> bit & 1u) | (y >> bit & 1u) << 1 | (up >> bit & 1u) << 2;
      node = nodeChildExists(node, child) ? getNodeChild(node, child) : createNodeChild(node, child);
    }
    copy(*tile.root(), node);
    size_changed = true;
  }

 private:
  void copy(const VoxelNode& from, octomap::OcTreeNode* to) {
    to->setLogOdds(from.getValue());
    for (unsigned i = 0; i < 8; ++i) {
      if (const VoxelNode* child = from.child(i)) copy(*child, createNodeChild(to, i));
    }
  }
};

/// Written here, since OctoMap's own functions that write it also print to stderr.
std::string header(std::string_view first_line, const octomap::OcTree& tree) {
  return fmt::format(
      "{}\n# (feel free to add / change comments, but leave the first line as it is!)\n#\nid {}\nsize {}\nres {}\n"
      "data\n",
      first_line, tree.getTreeType(), tree.size(), tree.getResolution());
}

}  // namespace

std::vector<MapFile> octomap_files(const VoxelMap& map, double resolution) {
  WholeOcTree tree(resolution);
  map.for_all([&](TileIndex index, const TileColumn& column, bool) {
    column.for_all([&](std::int32_t z, const VoxelTile& tile, bool) {
      if (!tile.voxels.is_unknown()) tree.add(index, z, tile.voxels);
    });
  });
  if (tree.size() == 0) return {};
  tree.updateInnerOccupancy();
  tree.prune();
  std::ostringstream full;
  full << header("# Octomap OcTree file", tree);
  tree.writeData(full);
  tree.toMaxLikelihood();
  tree.prune();
  std::ostringstream binary;
  binary << header("# Octomap OcTree binary file", tree);
  tree.writeBinaryData(binary);
  return {{".bt", std::move(binary).str()}, {".ot", std::move(full).str()}};
}

}  // namespace waymark::octo
