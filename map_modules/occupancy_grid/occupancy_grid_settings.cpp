// SPDX-License-Identifier: Apache-2.0
#include "occupancy_grid_settings.hpp"

namespace waymark::grid {

OccupancyGridSettings OccupancyGridSettings::read(const Config& config) {
  OccupancyGridSettings s{};
  s.resolution = config.number_in("resolution_m", 0.005, 10.0, 0.05);
  s.scan = ScanSettings::read(config, s.resolution);
  s.match = MatchSettings::read(config.child_or_empty("match"));
  s.odds = OddsSettings::read(config.child_or_empty("log_odds"));
  const LoadSettings loaded = LoadSettings::read(config);
  s.use = loaded.use;
  s.load = loaded.file;
  return s;
}

}  // namespace waymark::grid
