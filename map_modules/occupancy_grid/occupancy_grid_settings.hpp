// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "scan_settings.hpp"
#include "waymark/config/config.hpp"

namespace waymark::grid {

struct OccupancyGridSettings {
  double resolution;  ///< side of a cell [m]
  ScanSettings scan;
  MatchSettings match;
  OddsSettings odds;
  MapUse use = MapUse::map;
  std::filesystem::path load;  ///< YAML of a map to begin with; empty: none

  /// Reads the map's node of the YAML. Throws ConfigError.
  static OccupancyGridSettings read(const Config& config);
};

}  // namespace waymark::grid
