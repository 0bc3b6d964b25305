// SPDX-License-Identifier: Apache-2.0
#include "map_modules/feature_map/association/missed_landmarks.hpp"

#include "map_modules/feature_map/landmarks/existence.hpp"
#include "map_modules/feature_map/landmarks/visibility.hpp"

namespace waymark::feature_map {

double find_missed(const FeatureMapSettings& settings, const Pose& T_map_base, const FeatureObservation& observation,
                   FeatureAssociation& association) {
  association.missed.clear();
  if (!settings.use_negative_information) return 0.0;
  association.missed_log_odds.clear();
  const ExpectedView view(T_map_base, observation.view, settings.existence);
  for (const std::uint32_t n : association.nearby.within(view.center(), view.reach_square(), 0.0)) {
    const NearbyLandmarks::Entry& nearby = association.nearby[n];
    const StoredLandmark landmark = nearby.landmark;
    if (nearby.taken || !view.should_show({landmark.east(), landmark.north()}, landmark.radius())) continue;
    association.missed.push_back(nearby.ref);
    if (is_confirmed(landmark.sightings(), settings.existence))
      association.missed_log_odds.push_back(landmark.log_odds());
  }
  return log_likelihood_of_misses(association.missed_log_odds, settings.association.detection_probability,
                                  settings.existence);
}

}  // namespace waymark::feature_map
