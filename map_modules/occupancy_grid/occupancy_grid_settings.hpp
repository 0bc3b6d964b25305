// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "map_modules/shared/scan_matching/scan_settings.hpp"
#include "plugins/shared/map_formats/load_settings.hpp"
#include "waymark/config/config.hpp"

namespace waymark::occupancy_grid {

struct OccupancyGridSettings {
  double resolution;  ///< side of a cell [m]
  scan_matching::ScanSettings scan;
  scan_matching::MatchSettings match;
  scan_matching::OddsSettings odds;
  map_formats::LoadSettings load;  ///< the YAML of a map to begin with

  /// Reads the map's node of the YAML. Throws ConfigError.
  static OccupancyGridSettings read(const Config& config);
};

}  // namespace waymark::occupancy_grid
