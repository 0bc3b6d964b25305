// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "map_modules/shared/scan_matching/scan_settings.hpp"
#include "plugins/shared/map_formats/load_settings.hpp"
#include "waymark/config/config.hpp"

namespace waymark::octomap_grid {

/// From … to, both belong to it [m].
struct Heights {
  double low;
  double high;
  bool hold(double z) const { return z >= low && z <= high; }
};

/// What a match moves, and on what: x, y and yaw on the likelihood field of each layer; x, y and yaw on small planes
/// (surfels); all six of the pose on small planes.
enum class MatchKind { planar, planes, spatial };

struct OctomapGridSettings {
  double resolution;  ///< side of a voxel [m]
  scan_matching::ScanSettings scan;
  scan_matching::MatchSettings match;
  scan_matching::OddsSettings odds;
  Heights match_heights;  ///< above the base, along the map's z: points that are matched
  int max_match_points;   ///< of a cloud
  MatchKind match_kind;
  double surfel_cell;  ///< side of the smallest cells of surfels [m]
  Heights slice;       ///< in the map: what is seen from above
  map_formats::LoadSettings load;

  /// Reads the map's node of the YAML. Throws ConfigError.
  static OctomapGridSettings read(const Config& config);

  bool is_spatial() const { return match_kind == MatchKind::spatial; }
  bool has_surfels() const { return match_kind != MatchKind::planar; }
};

}  // namespace waymark::octomap_grid
