// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <octomap/OcTree.h>

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <vector>

namespace waymark::maps {

/// From where an octree is looked at: a parallel projection from above.
struct OctreeView {
  double from_deg = 225.0;                                  ///< where the spectator stands, from east to north
  double tilt_deg = 35.0;                                   ///< 0: from the side, 90: from above
  double low_m = -std::numeric_limits<double>::infinity();  ///< what lies lower is left out
  double high_m = std::numeric_limits<double>::infinity();  ///< what lies higher is left out, such as a ceiling
  int width_px = 1600;
};

/// Rows of red, green, blue from the upper left corner.
struct Picture {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;
};

/// The occupied voxels, coloured by height from violet (low) to red (high), and a path above them (may be empty).
/// Throws Error if no occupied voxel lies within the heights, or if there are too many.
Picture picture_of(const octomap::OcTree& tree, const OctreeView& view, const std::vector<Eigen::Vector3d>& path);

/// Writes a PNG. Throws Error.
void write_png(const Picture& picture, const std::filesystem::path& file);

}  // namespace waymark::maps
