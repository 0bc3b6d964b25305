// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/map_formats/load_settings.hpp"

#include <string>

namespace waymark::map_formats {

LoadSettings LoadSettings::read(const Config& config) {
  LoadSettings s;
  const std::string mode = config.choice(
      {"mode", "`map`: a new map; with `load`: `continue` (the map is updated) or `localize` (it stays as it is)"},
      {"map", "continue", "localize"}, "map");
  s.use = mode == "map" ? MapUse::map : mode == "continue" ? MapUse::continue_map : MapUse::localize;
  if (config.has("load")) {
    const std::string file =
        config.text({"load", "",
                     "file of a prior map, relative to the YAML: a YAML of `map_server` (occupancy_grid), a `.bt` or "
                     "`.ot` (octomap_grid), a `.landmarks.yaml` (feature_map)",
                     "none"});
    if (file.empty()) config.fail("load", "is empty; the file of a map is expected");
    s.file = config.file().parent_path() / file;
  }
  if (s.use == MapUse::map && !s.file.empty()) config.fail("mode", "must be continue or localize for a loaded map");
  if (s.use != MapUse::map && s.file.empty()) config.fail("mode", "continue and localize need a map: load");
  return s;
}

}  // namespace waymark::map_formats
