// SPDX-License-Identifier: Apache-2.0
#include "map_modules/feature_map/landmarks/existence.hpp"

#include <algorithm>
#include <cmath>

namespace waymark::feature_map {

double existence_probability(float log_odds) { return 1.0 / (1.0 + std::exp(-static_cast<double>(log_odds))); }

float log_odds_after_hit(float log_odds, const ExistenceSettings& settings) {
  return std::min(log_odds + static_cast<float>(settings.log_odds_hit), static_cast<float>(settings.log_odds_max));
}

float log_odds_after_miss(float log_odds, const ExistenceSettings& settings) {
  return log_odds + static_cast<float>(settings.log_odds_miss);
}

bool survives(float log_odds, std::int32_t sightings, const ExistenceSettings& settings) {
  return !(log_odds < (is_confirmed(sightings, settings) ? settings.delete_below : settings.delete_provisional_below));
}

double log_likelihood_of_misses(std::vector<float>& log_odds, double detection_probability,
                                const ExistenceSettings& settings) {
  // Only so many count: the most certain ones, whatever the order in which they are stored.
  std::ranges::sort(log_odds, std::ranges::greater{});
  const std::size_t most = std::min(log_odds.size(), static_cast<std::size_t>(settings.max_misses));
  double log_factor = 0.0;
  for (std::size_t i = 0; i < most; ++i)
    log_factor += std::log1p(-detection_probability * existence_probability(log_odds[i]));
  return log_factor;
}

}  // namespace waymark::feature_map
