// SPDX-License-Identifier: Apache-2.0
#include "map_modules/feature_map/association/ambiguity.hpp"

#include <algorithm>

namespace waymark::feature_map {

Rivals rivals_of(std::size_t detection, const FeatureAssociation& association, double least) {
  Rivals rivals{least, least};
  for (const FeatureAssociation::Pair& pair : association.pairs) {
    if (static_cast<std::size_t>(pair.detection) != detection) continue;
    const LandmarkRef ref = association.nearby[static_cast<std::size_t>(pair.nearby)].ref;
    double& likelihood = ref == association.landmark_of[detection] ? rivals.chosen : rivals.other;
    likelihood = std::max(likelihood, pair.log_likelihood);
  }
  return rivals;
}

void count_ambiguous(double log_p0, FeatureAssociation& association) {
  constexpr double kLogTen = 2.302585092994046;
  association.associated = 0;
  association.ambiguous = 0;
  for (std::size_t d = 0; d < association.landmark_of.size(); ++d) {
    if (association.landmark_of[d].chunk < 0) continue;
    const Rivals rivals = rivals_of(d, association, log_p0);
    ++association.associated;
    association.ambiguous += rivals.other > rivals.chosen - kLogTen;
  }
}

void reject_doubtful_new(const FeatureMapSettings& settings, const Pose& T_map_base,
                         const FeatureObservation& observation, FeatureAssociation& association) {
  const double separation = settings.association.min_separation;
  for (std::size_t d = 0; d < observation.detections.size(); ++d) {
    if (association.landmark_of[d].chunk != FeatureAssociation::kNew) continue;
    if (!observation.detections[d].may_be_new) {
      association.landmark_of[d].chunk = FeatureAssociation::kAmbiguous;
      continue;
    }
    const Eigen::Vector3d& xyr = observation.detections[d].xyr;
    const Eigen::Vector2d p = (T_map_base * Eigen::Vector3d(xyr.x(), xyr.y(), 0.0)).head<2>();
    const auto near = association.nearby.within(p, separation * separation, 0.0);
    const bool close = std::ranges::any_of(near, [&](std::uint32_t n) {
      return (association.nearby[n].landmark.mean().head<2>() - p).squaredNorm() < separation * separation;
    });
    if (close) association.landmark_of[d].chunk = FeatureAssociation::kAmbiguous;
  }
}

}  // namespace waymark::feature_map
