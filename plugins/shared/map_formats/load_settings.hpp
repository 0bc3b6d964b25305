// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "waymark/config/config.hpp"

namespace waymark::map_formats {

/// What a map that was loaded is for.
enum class MapUse {
  map,           ///< none is loaded
  continue_map,  ///< it goes on being written
  localize       ///< it stays as it is
};

/// The map to begin with, as the YAML names it.
struct LoadSettings {
  MapUse use = MapUse::map;
  std::filesystem::path file;  ///< empty: none

  /// From the keys `mode` and `load` of the map's node. Throws ConfigError.
  static LoadSettings read(const Config& config);
};

}  // namespace waymark::map_formats
