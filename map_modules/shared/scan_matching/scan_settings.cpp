// SPDX-License-Identifier: Apache-2.0
#include "map_modules/shared/scan_matching/scan_settings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace waymark::scan_matching {

namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180.0;

/// Some seconds for one scan.
constexpr double kMostPlaces = 1e5;

/// A scan reaches so many cells at most: it is looked at in one window of tiles.
constexpr double kLongestReach = 5000.0;

}  // namespace

ScanSettings ScanSettings::read(const Config& config, double resolution) {
  ScanSettings s{};
  s.range_min = config.non_negative({"range_min_m", "m", "nearer returns are not used"}, 0.1);
  s.range_max = config.positive({"range_max_m", "m", "farther returns are not used"}, 40.0);
  s.no_return = config.positive(
      {"no_return_m", "m", "readings at or above this mean that nothing came back", "range_max_m"}, s.range_max);
  s.no_return_clears = config.non_negative(
      {"no_return_clears_m", "m", "how far a beam on which nothing came back marks the map as free; 0: not at all"},
      0.0);
  s.update_distance = config.non_negative({"update_distance_m", "m", "a scan is used after this distance"}, 0.2);
  s.update_angle =
      kRadPerDeg * config.non_negative({"update_angle_deg", "°", "a scan is also used after this turn"}, 11.5);
  s.update_after = from_seconds(
      config.non_negative({"update_after_s", "s", "a scan is also used after this time; 0: no such rule"}, 0.0));
  if (s.range_max <= s.range_min)
    config.fail("range_max_m", fmt::format("{:g} must exceed range_min_m, which is {:g}", s.range_max, s.range_min));
  if (std::max(s.range_max, s.no_return_clears) > kLongestReach * resolution) {
    config.fail(s.range_max > kLongestReach * resolution ? "range_max_m" : "no_return_clears_m",
                "must be at most 5000 times resolution_m");
  }
  if (s.no_return_clears > s.no_return) config.fail("no_return_clears_m", "must not exceed no_return_m");
  return s;
}

MatchSettings MatchSettings::read(const Config& config, const MatchDefaults& defaults) {
  MatchSettings s{};
  s.wide_sigma =
      config.positive({"wide_sigma_m", "m", "σ of the wide field; the stored distances end at 6 times `resolution_m`",
                       defaults.wide_sigma_text},
                      defaults.wide_sigma);
  s.narrow_sigma = config.positive({"narrow_sigma_m", "m", "σ of the narrow field", defaults.narrow_sigma_text},
                                   defaults.narrow_sigma);
  s.curvature_scale = config.positive({"curvature_scale",
                                       "κ: information of a squared residual; fewer particles and sparse beams: 100; "
                                       "many beams on the same walls (541 in `config/hybrid.yaml`): 1.5"},
                                      100.0);
  s.evidence_tempering = config.number_in({"evidence_tempering", "τ: about 1/particles, 0.02 to 0.1"}, 0.0, 1.0, 0.03);
  s.search_score = config.number_in({"search_score", "mean likelihood L of the end points below which the search runs"},
                                    0.0, 1.0, defaults.search_score);
  s.min_score = config.number_in({"min_score", "mean likelihood L of the end points below which a match has failed"},
                                 0.0, 1.0, defaults.min_score);
  s.max_iterations =
      static_cast<int>(config.integer_in({"max_iterations", "iterations of each stage, at most"}, 1, 1000, 12));
  s.coarse_distance = config.non_negative(
      {"coarse_distance_m", "m", "half width of the search in x and y; 100 000 poses at most"}, 0.28);
  s.coarse_angle =
      kRadPerDeg * config.number_in({"coarse_angle_deg", "°",
                                     "half width of the search in yaw; where nothing fits, three times as far"},
                                    0.0, 180.0, 7.0);
  s.spread_draws = static_cast<int>(config.integer_in(
      {"spread_draws", "poses tried when the prior is far wider than the search, or nothing fits in it; 0: none"}, 0,
      10'000'000, 10'000));
  const double position = config.positive(
      {"sigma_floor_m", "m", "σ of x and y that is added to every match (F): no pose is better known than that"},
      0.001);
  s.floor = {
      position, position,
      kRadPerDeg * config.positive({"sigma_floor_deg", "°",
                                    "σ of yaw that is added to every match (F): no pose is better known than that"},
                                   0.03)};
  const double across = 2.0 * s.coarse_distance / (s.kSearchStep * s.wide_sigma) + 1.0;
  const double places = across * across * (2.0 * s.coarse_angle / s.kSearchYawStep + 1.0);
  if (places > kMostPlaces) {
    config.fail(
        "coarse_distance_m",
        fmt::format("with coarse_angle_deg and wide_sigma_m, makes {:.3g} places to search for every particle and "
                    "scan that does not fit; at most {:g} are possible",
                    places, kMostPlaces));
  }
  if (s.wide_sigma < s.narrow_sigma) config.fail("wide_sigma_m", "must not be below narrow_sigma_m");
  return s;
}

OddsSettings OddsSettings::read(const Config& config) {
  const auto steps = [&](const Config::Key& key, double least, double most, double fallback) {
    return static_cast<int>(std::lround(kSteps * config.number_in(key, least, most, fallback)));
  };
  OddsSettings s{};
  s.hit = steps({"hit", "added where a beam ends"}, 1.0 / kSteps, 6.0, 0.85);
  s.miss = steps({"miss", "added where a beam passes"}, -6.0, -1.0 / kSteps, -0.4);
  s.low = steps({"min", "lower bound"}, -6.0, -1.0 / kSteps, -2.0);
  s.high = steps({"max", "upper bound"}, 1.0 / kSteps, 6.0, 3.5);
  return s;
}

}  // namespace waymark::scan_matching
