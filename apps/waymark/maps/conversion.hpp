// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <octomap/OcTree.h>

#include <memory>

#include "waymark/interface/map_view.hpp"

namespace waymark::maps {

/// Heights between which an octree is looked at from above.
struct Slice {
  double low_m = 0.0;
  double high_m = 0.0;
};

/// The columns of all voxels whose middles lie within the slice: occupied if one of them is, else free if one of them
/// is. Throws Error if no layer of voxels has its middle there, if nothing is known there, or if the picture would be
/// too large.
GridView slice_of(const octomap::OcTree& tree, const Slice& slice);

/// One layer of voxels of a grid's cells, its lower side at the height 0. The cells move by up to half a cell each way,
/// to where voxels can be. Throws Error if the grid is turned, or does not fit into an octree.
std::unique_ptr<octomap::OcTree> layer_of(const GridView& grid);

}  // namespace waymark::maps
