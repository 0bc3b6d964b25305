// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

#include "waymark/config/config.hpp"
#include "waymark/interface/map_module.hpp"
#include "waymark/math/pose.hpp"

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
  std::filesystem::path file;          ///< empty: none
  Pose T_map_file;                     ///< where the coordinates of the file lie, by a manifest: planar, with a height
  std::optional<MapFrame> frame = {};  ///< as the manifest says

  /// From the keys `name`, `mode` and `load` of the map's node. `load` names a file of this format, or a manifest, of
  /// which it is the layer with the map's name, or the only one of this format. A file that the manifest of its folder
  /// names lies where that says. Throws ConfigError.
  static LoadSettings read(const Config& config, std::string_view format);
};

}  // namespace waymark::map_formats
