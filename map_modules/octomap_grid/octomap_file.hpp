// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "map_modules/octomap_grid/octomap_grid_settings.hpp"
#include "map_modules/octomap_grid/voxel_tile.hpp"
#include "waymark/interface/particle_map.hpp"

namespace waymark::octomap_grid {

/// The whole map as OctoMap's files: ".ot" with all log-odds, and ".bt", occupied or free, smaller. Throws Error if it
/// reaches farther from the map's origin than an octree of depth 16 does.
std::vector<MapFile> octomap_files(const VoxelMap& map, double resolution);

/// Reads an octree out of a .bt or .ot file. What a .bt file holds gets half of the odds that many scans would give it;
/// log-odds of a .ot file are cut to what the settings allow. Throws DataError with the file, the value and what was
/// expected: if there is none, if it is not a valid octree, if its voxels have another
/// size than `resolution_m`, or if the map would take more memory than a map can.
VoxelMap load_octomap(const std::filesystem::path& file, const OctomapGridSettings& settings);

}  // namespace waymark::octomap_grid
