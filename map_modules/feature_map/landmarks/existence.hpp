// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "map_modules/feature_map/feature_map_settings.hpp"

/// Whether a landmark exists: its log-odds, from its birth as a provisional one to its death.
namespace waymark::feature_map {

/// From log-odds, 0 … 1.
double existence_probability(float log_odds);

/// After that many sightings a landmark is no longer provisional.
inline bool is_confirmed(std::int32_t sightings, const ExistenceSettings& settings) {
  return sightings >= settings.min_observations;
}

/// Log-odds after another sighting.
float log_odds_after_hit(float log_odds, const ExistenceSettings& settings);

/// Log-odds after a scan that should have seen the landmark and did not.
float log_odds_after_miss(float log_odds, const ExistenceSettings& settings);

/// False if a landmark with these log-odds is to be removed.
bool survives(float log_odds, std::int32_t sightings, const ExistenceSettings& settings);

/// Σ log(1 − P_D P_exist) over the most certain `max_misses` of the landmarks that were missed; sorts their log-odds.
double log_likelihood_of_misses(std::vector<float>& log_odds, double detection_probability,
                                const ExistenceSettings& settings);

}  // namespace waymark::feature_map
