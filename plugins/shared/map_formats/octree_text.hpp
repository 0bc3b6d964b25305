// SPDX-License-Identifier: Apache-2.0
#pragma once

// Included only by who links liboctomap: sinks that write other formats do without.
#include <octomap/OcTree.h>

#include <sstream>
#include <string>
#include <utility>

#include "plugins/shared/map_formats/octree_bytes.hpp"
#include "waymark/base/error.hpp"

namespace waymark::map_formats {

/// Which of OctoMap's formats.
enum class OctreeFormat {
  binary,  ///< .bt: a voxel is occupied or free
  full     ///< .ot: every node has its log-odds
};

/// The bytes of a file. `.bt` keeps of every voxel only whether it is occupied, and the tree is pruned for it. Throws
/// Error if liboctomap cannot write them.
inline std::string octree_text(octomap::OcTree& tree, OctreeFormat format) {
  // Calling the template keeps its own debug output switched off.
  using Tree = octomap::OccupancyOcTreeBase<octomap::OcTreeNode>;
  const bool is_binary = format == OctreeFormat::binary;
  if (is_binary) {
    tree.toMaxLikelihood();
    tree.prune();
  }
  std::ostringstream out;
  out << octree_header(is_binary, tree.size(), tree.getResolution());
  if (is_binary) {
    tree.Tree::writeBinaryData(out);
  } else {
    tree.Tree::writeData(out);
  }
  if (!out) throw Error("liboctomap could not write an octree");
  return std::move(out).str();
}

}  // namespace waymark::map_formats
