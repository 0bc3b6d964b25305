// SPDX-License-Identifier: Apache-2.0
#include "map_modules/octomap_grid/octomap_grid_settings.hpp"

#include <utility>
#include <vector>

#include "plugins/shared/map_formats/map_manifest.hpp"

namespace waymark::octomap_grid {

namespace {

// Farther than any map reaches: all heights count.
constexpr double kAnyHeight = 1e4;

/// A scan reaches so many voxels at most: its tiles are looked at in one box.
constexpr double kLongestReach = 2000.0;

Heights read_heights(const Config& config, const Config::Key& key) {
  const std::vector<double> both = config.numbers(key, 2, {-kAnyHeight, kAnyHeight});
  if (both[0] >= both[1]) config.fail(key.name, "the first number must be below the second");
  return {both[0], both[1]};
}

}  // namespace

OctomapGridSettings OctomapGridSettings::read(const Config& config) {
  OctomapGridSettings s{};
  s.resolution = config.number_in(
      {"resolution_m", "m", "side of a voxel; `range_max_m` and `no_return_clears_m` are 2000 voxels at most"}, 0.005,
      10.0, 0.1);
  s.scan = scan_matching::ScanSettings::read(config, s.resolution);
  for (const auto& [key, value] :
       {std::pair{"range_max_m", s.scan.range_max}, std::pair{"no_return_clears_m", s.scan.no_return_clears}}) {
    if (value > kLongestReach * s.resolution) config.fail(key, "must be at most 2000 times resolution_m");
  }
  const Config match = config.child_or_empty({"match", "how scans are matched on the likelihood field"});
  const std::string kind = match.choice(
      {"kind",
       "`planar`: x, y and yaw, on the likelihood field of each layer; `planes`: the same, on small planes; "
       "`spatial`: height, roll and pitch, too, on small planes (`motion.kind: spatial`)"},
      {"planar", "planes", "spatial"}, "planar");
  s.match_kind = kind == "planar" ? MatchKind::planar : kind == "planes" ? MatchKind::planes : MatchKind::spatial;
  s.match = scan_matching::MatchSettings::read(match, s.match_kind == MatchKind::planar
                                                          ? scan_matching::MatchDefaults::cells(s.resolution)
                                                          : scan_matching::MatchDefaults::planes());
  s.match_heights =
      read_heights(match, {"height_m", "m", "[low, high] above the base: points that are matched", "all"});
  s.max_match_points = static_cast<int>(
      match.integer_in({"max_points", "points of a cloud that are matched, at most"}, 1, 1'000'000, 1000));
  s.surfel_cell = match.number_in(
      {"cell_m", "m", "with `kind: planes` or `spatial`: side of the smallest cells that have a plane each",
       "4 * resolution_m"},
      s.resolution, 100.0, 4.0 * s.resolution);
  s.odds = scan_matching::OddsSettings::read(
      config.child_or_empty({"log_odds", "what hits and misses add, and bounds: natural logarithms, rounded to 1/20"}));
  s.slice = read_heights(config, {"slice_m", "m",
                                  "[low, high]: heights in the map of the view from above: the largest probability "
                                  "over the layers whose middles lie there",
                                  "all"});
  s.load = map_formats::LoadSettings::read(config, map_formats::kOctreeFormat);
  return s;
}

}  // namespace waymark::octomap_grid
