// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "apps/waymark/evaluation/surfaces.hpp"
#include "apps/waymark/evaluation/trajectory_error.hpp"

namespace waymark::evaluation {

/// How an octree is scored.
struct VoxelOptions {
  double tolerance_m = 0.0;  ///< between the middle of a voxel and a surface; 0: the side of a voxel
};

/// Occupied voxels against true surfaces, and these against the voxels. Both are taken to lie in one frame.
struct VoxelError {
  double tolerance_m = 0.0;    ///< that was used
  std::uint64_t occupied = 0;  ///< voxels of the finest level
  std::uint64_t right = 0;     ///< of these, no further than the tolerance from a surface
  ErrorStatistics distance_m;  ///< from the middles of the occupied voxels to the nearest surface
  std::uint64_t points = 0;    ///< of the surfaces, within the map's corners, a voxel's side apart
  std::uint64_t found = 0;     ///< of these, an occupied voxel is no further than the tolerance
  std::uint64_t missed = 0;    ///< of these, there is none, but a free one is there; the rest was not seen

  double precision() const;  ///< right / occupied; NaN if there is none
  double recall() const;     ///< found / (found + missed); NaN if there is none
};

/// `octree`: .bt or .ot. Throws DataError, also if no voxel is occupied; Error for a tolerance of
/// more than ten voxels.
VoxelError score_voxels(const std::filesystem::path& octree, const std::vector<Surface>& surfaces,
                        const VoxelOptions& options);

}  // namespace waymark::evaluation
