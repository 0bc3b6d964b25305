// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <octomap/OcTree.h>

#include <memory>

#include "waymark/math/pose.hpp"

namespace waymark::maps {

struct Box;

/// The voxels whose middles lie in the box; `T_frame_tree` is where the tree lies in the box's frame. Throws Error if
/// that needs too many leaves, since one of kilometres is cut.
std::unique_ptr<octomap::OcTree> crop_octree(const octomap::OcTree& tree, const Box& box, const Pose& T_frame_tree);

/// Adds the log-odds of another tree, each voxel where its middle lies. Throws Error if the resolutions differ, if
/// there are too many voxels, or if they lie beyond what an octree reaches.
void merge_octrees(octomap::OcTree& tree, const octomap::OcTree& other, const Pose& T_tree_other);

}  // namespace waymark::maps
