// SPDX-License-Identifier: Apache-2.0
#include "octree_edits.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "map_edits.hpp"
#include "waymark/base/error.hpp"

namespace waymark::maps {

namespace {

// A few bytes may claim a cube of kilometres.
constexpr std::uint64_t kMostCutLeaves = std::uint64_t{1} << 26;
constexpr std::uint64_t kMostMergedVoxels = std::uint64_t{1} << 28;

/// An octree into which leaves are put as they are.
class LeafOcTree final : public octomap::OcTree {
 public:
  explicit LeafOcTree(double voxel_m) : OcTree(voxel_m) {}

  /// A leaf of 2^level voxels in each direction; `low` is its lowest one, counted from the map's origin.
  void add(const std::array<int, 3>& low, int level, float odds) {
    std::array<unsigned, 3> key{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      key[axis] = static_cast<unsigned>(low[axis] + static_cast<int>(tree_max_val));
    if (root == nullptr) {
      root = new octomap::OcTreeNode;
      ++tree_size;
    }
    octomap::OcTreeNode* node = root;
    for (int bit = static_cast<int>(tree_depth) - 1; bit >= level; --bit) {
      const unsigned child = (key[0] >> bit & 1u) | (key[1] >> bit & 1u) << 1 | (key[2] >> bit & 1u) << 2;
      node = nodeChildExists(node, child) ? getNodeChild(node, child) : createNodeChild(node, child);
    }
    node->setLogOdds(odds);
    size_changed = true;
  }
};

/// Puts into another tree what of the leaves lies in a box.
class Cropping {
 public:
  Cropping(LeafOcTree& out, const Box& box, const Pose& T_frame_tree)
      : out_(out), box_(box), T_frame_tree_(T_frame_tree), turn_(T_frame_tree.q.toRotationMatrix()) {}

  void add(const std::array<int, 3>& low, int level, float odds) {
    const double side = std::ldexp(out_.getResolution(), level);
    const Eigen::Vector3d corner = out_.getResolution() * Eigen::Vector3d(low[0], low[1], low[2]);
    const Eigen::Vector3d middle = T_frame_tree_ * (corner + Eigen::Vector3d::Constant(0.5 * side));
    if (level == 0) {
      if (box_.holds(middle)) keep(low, level, odds);
      return;
    }
    const Eigen::Vector3d reach = 0.5 * side * turn_.cwiseAbs().rowwise().sum();  // along the axes of the box
    const Eigen::Vector3d box_low(box_.west, box_.south, box_.low);
    const Eigen::Vector3d box_high(box_.east, box_.north, box_.high);
    if (((middle + reach).array() < box_low.array()).any() || ((middle - reach).array() > box_high.array()).any())
      return;
    if (((middle - reach).array() >= box_low.array()).all() && ((middle + reach).array() <= box_high.array()).all())
      return keep(low, level, odds);
    const int half = 1 << (level - 1);
    for (int i = 0; i < 8; ++i)
      add({low[0] + (i & 1) * half, low[1] + (i >> 1 & 1) * half, low[2] + (i >> 2 & 1) * half}, level - 1, odds);
  }

 private:
  void keep(const std::array<int, 3>& low, int level, float odds) {
    if (++leaves_ > kMostCutLeaves)
      throw Error(fmt::format("the box cuts the octree into more than {} leaves", kMostCutLeaves));
    out_.add(low, level, odds);
  }

  LeafOcTree& out_;
  const Box& box_;
  const Pose& T_frame_tree_;
  Eigen::Matrix3d turn_;
  std::uint64_t leaves_ = 0;
};

}  // namespace

std::unique_ptr<octomap::OcTree> crop_octree(const octomap::OcTree& tree, const Box& box, const Pose& T_frame_tree) {
  auto out = std::make_unique<LeafOcTree>(tree.getResolution());
  Cropping cropping(*out, box, T_frame_tree);
  for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf) {
    const int level = static_cast<int>(tree.getTreeDepth() - leaf.getDepth());
    cropping.add(box_of(leaf, tree).low, level, leaf->getLogOdds());
  }
  if (out->size() == 0) return out;
  out->updateInnerOccupancy();
  out->prune();
  return out;
}

void merge_octrees(octomap::OcTree& tree, const octomap::OcTree& other, const Pose& T_tree_other) {
  const double resolution = tree.getResolution();
  if (std::abs(resolution - other.getResolution()) > 1e-9) {
    throw Error(fmt::format("voxels of {} m and of {} m; octrees of one resolution are expected", resolution,
                            other.getResolution()));
  }
  std::uint64_t voxels = 0;
  for (auto leaf = other.begin_leafs(); leaf != other.end_leafs(); ++leaf) {
    const VoxelBox box = box_of(leaf, other);
    const auto side = static_cast<std::uint64_t>(box.high[0] - box.low[0]);
    voxels += side * side * side;
    if (voxels > kMostMergedVoxels) throw Error(fmt::format("more than {} voxels are to be merged", kMostMergedVoxels));
    const float odds = leaf->getLogOdds();
    for (int z = box.low[2]; z < box.high[2]; ++z) {
      for (int y = box.low[1]; y < box.high[1]; ++y) {
        for (int x = box.low[0]; x < box.high[0]; ++x) {
          const Eigen::Vector3d p = T_tree_other * (resolution * Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5));
          octomap::OcTreeKey key;
          if (!tree.coordToKeyChecked(p.x(), p.y(), p.z(), key))
            throw Error("a voxel lies beyond what an octree reaches");
          const octomap::OcTreeNode* mine = tree.search(key);
          const float sum = odds + (mine != nullptr ? mine->getLogOdds() : 0.0F);
          tree.setNodeValue(key, std::clamp(sum, tree.getClampingThresMinLog(), tree.getClampingThresMaxLog()), true);
        }
      }
    }
  }
  tree.updateInnerOccupancy();
  tree.prune();
}

}  // namespace waymark::maps
