// SPDX-License-Identifier: Apache-2.0
#include "map_modules/occupancy_grid/occupancy_grid_settings.hpp"

#include "plugins/shared/map_formats/map_manifest.hpp"

namespace waymark::occupancy_grid {

OccupancyGridSettings OccupancyGridSettings::read(const Config& config) {
  OccupancyGridSettings s{};
  s.resolution = config.number_in(
      {"resolution_m", "m", "side of a cell; `range_max_m` and `no_return_clears_m` are 5000 cells at most"}, 0.005,
      10.0, 0.05);
  s.scan = scan_matching::ScanSettings::read(config, s.resolution);
  s.match = scan_matching::MatchSettings::read(
      config.child_or_empty({"match", "how scans are matched on the likelihood field"}),
      scan_matching::MatchDefaults::cells(s.resolution));
  s.odds = scan_matching::OddsSettings::read(
      config.child_or_empty({"log_odds", "what hits and misses add, and bounds: natural logarithms, rounded to 1/20"}));
  s.load = map_formats::LoadSettings::read(config, map_formats::kMapServerFormat);
  return s;
}

}  // namespace waymark::occupancy_grid
