// SPDX-License-Identifier: Apache-2.0
#include "map_modules/feature_map/association/association.hpp"

#include <algorithm>

#include "map_modules/feature_map/association/association_methods.hpp"
#include "map_modules/feature_map/association/candidate_pairs.hpp"

namespace waymark::feature_map {

namespace {

bool holds_identity(const LandmarkStore& store, int identity) {
  bool found = false;
  store.for_all([&](const StoredLandmark& landmark) { found = found || landmark.identity() == identity; });
  return found;
}

/// Detections without a landmark are ambiguous, but the first one of an identity that no landmark has: that is new.
void reject_known_identities(const LandmarkStore& store, const FeatureObservation& observation,
                             FeatureAssociation& association) {
  const auto& detections = observation.detections;
  for (std::size_t d = 0; d < detections.size(); ++d) {
    if (association.landmark_of[d].chunk >= 0) continue;
    const int identity = detections[d].identity;
    const bool repeated = std::any_of(detections.begin(), detections.begin() + static_cast<std::ptrdiff_t>(d),
                                      [&](const Detection& other) { return other.identity == identity; });
    if (identity < 0 || repeated || holds_identity(store, identity))
      association.landmark_of[d].chunk = FeatureAssociation::kAmbiguous;
  }
}

/// A likely identity of a landmark somewhere in the map makes no second one: the pose is off, or it was misread.
void reject_known_signatures(const LandmarkStore& store, const FeatureObservation& observation,
                             FeatureAssociation& association) {
  constexpr float kLikely = 0.5f;
  for (std::size_t d = 0; d < observation.detections.size(); ++d) {
    const int identity = observation.detections[d].identity;
    if (association.landmark_of[d].chunk >= 0 || identity < 0) continue;
    bool known = false;
    store.for_all([&](const Landmark& landmark) {
      known = known || landmark.signature[static_cast<std::size_t>(identity)] > kLikely;
    });
    if (known) association.landmark_of[d].chunk = FeatureAssociation::kAmbiguous;
  }
}

}  // namespace

template <int D>
void associate(const LandmarkStore& store, const FeatureMapSettings& settings, double log_p0,
               const Eigen::Vector3d& pose, const Eigen::Matrix3d& P, const FeatureObservation& observation,
               FeatureAssociation& association) {
  association.pairs.clear();
  association.landmark_of.assign(observation.detections.size(), LandmarkRef{});
  if (settings.identity == IdentityUse::known) {
    collect_identity_pairs<D>(settings, pose, P, observation, association);
    associate_greedily(association);
    reject_known_identities(store, observation, association);
    return;
  }
  collect_pairs<D>(settings, log_p0, pose, P, observation, association);
  switch (settings.association.method) {
    case AssociationMethod::greedy:
      associate_greedily(association);
      break;
    case AssociationMethod::optimal:
      associate_optimally(log_p0, association);
      break;
  }
  if (settings.identity == IdentityUse::signature) reject_known_signatures(store, observation, association);
}

template void associate<2>(const LandmarkStore&, const FeatureMapSettings&, double, const Eigen::Vector3d&,
                           const Eigen::Matrix3d&, const FeatureObservation&, FeatureAssociation&);
template void associate<3>(const LandmarkStore&, const FeatureMapSettings&, double, const Eigen::Vector3d&,
                           const Eigen::Matrix3d&, const FeatureObservation&, FeatureAssociation&);

}  // namespace waymark::feature_map
