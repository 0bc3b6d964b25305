// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <octomap/OcTree.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>

#include "plugins/shared/map_formats/octree_text.hpp"

namespace waymark::maps {

/// An octree, never null, and the format that it was read from.
struct LoadedOctree {
  std::unique_ptr<octomap::OcTree> tree;
  map_formats::OctreeFormat format = map_formats::OctreeFormat::binary;
};

/// Reads a `.bt` or `.ot`; its first line decides which. Throws DataError with the file, what is wrong and what was
/// expected.
LoadedOctree read_octree(const std::filesystem::path& file);

/// Counted in voxels of the finest level, whatever the size of the leaves.
struct OctreeFigures {
  std::array<double, 3> low_m{};   ///< lower corner of what is known
  std::array<double, 3> high_m{};  ///< upper corner
  std::uint64_t occupied = 0;
  std::uint64_t free = 0;
  std::uint64_t unknown = 0;  ///< within the corners
  std::size_t leaves = 0;
};

/// All zero for an empty tree.
OctreeFigures figures_of(const octomap::OcTree& tree);

/// The lower and upper corner of a leaf in voxels of the finest level, counted from the map's origin.
struct VoxelBox {
  std::array<int, 3> low;
  std::array<int, 3> high;  ///< the first beyond it
};
VoxelBox box_of(const octomap::OcTree::leaf_iterator& leaf, const octomap::OcTree& tree);

}  // namespace waymark::maps
