// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "map_modules/occupancy_grid/occupancy_grid_settings.hpp"
#include "map_modules/occupancy_grid/tile_tree.hpp"
#include "waymark/math/pose.hpp"

namespace waymark::occupancy_grid {

/// A map as it was loaded, and where its cells lie.
struct LoadedMap {
  TileTree tiles;
  double resolution = 0.0;  ///< [m]
  Pose T_map_grid;          ///< of the corner of cell (0, 0), planar
};

/// Reads a map of `map_server` (ROS): a YAML that names a binary greymap (PGM, P5). Its pixels are taken as they are,
/// edited or not: occupied, free or unknown by the YAML's thresholds; what is known gets half of the odds that many
/// scans would give it. Throws ConfigError or DataError with the file, the value and what was expected.
LoadedMap load_map_file(const std::filesystem::path& yaml, const scan_matching::OddsSettings& odds);

}  // namespace waymark::occupancy_grid
