// SPDX-License-Identifier: Apache-2.0
#include "association.hpp"

#include <algorithm>
#include <cmath>

#include "association_methods.hpp"

namespace waymark {

namespace {

/// Calls visit(detection, nearby, νᵀ Z⁻¹ ν, |Z|) for all pairs within `gate` that `wanted` lets through; Z has the
/// pose's share.
template <int D, class Wanted, class Visit>
void for_gated_pairs(double gate, const Eigen::Vector3d& pose, const Eigen::Matrix3d& P,
                     const FeatureObservation& observation, FeatureAssociation& association, const Wanted& wanted,
                     const Visit& visit) {
  using Model = DetectionModel<D>;
  for (std::size_t d = 0; d < observation.detections.size(); ++d) {
    const Detection& detection = observation.detections[d];
    const Model model(detection, pose);
    const auto H = model.jacobian(model.z.template head<2>());
    const typename Model::Matrix A = H * P * H.transpose() + model.R;
    const Eigen::Vector2d p = model.z.template head<2>();
    for (const std::uint32_t n : association.nearby.within(p, gate * (A(0, 0) + A(1, 1)), gate)) {
      const StoredLandmark landmark = association.nearby[n].landmark;
      if (!wanted(detection, landmark)) continue;
      const typename Model::Vector nu = model.z - landmark.mean().template head<D>();
      const typename Model::Matrix Z =
          A + landmark.covariance().template topLeftCorner<D, D>();  // (4.6) with the pose's share
      const typename Model::Matrix Z_inverse = Z.inverse();
      const double distance = nu.dot(Z_inverse * nu);
      if (distance <= gate) visit(d, n, distance, Z.determinant());
    }
  }
}

/// Pairs by place and signature: within the gate and likelier than a new landmark.
template <int D>
void collect_pairs(const FeatureMapSettings& settings, double log_p0, const Eigen::Vector3d& pose,
                   const Eigen::Matrix3d& P, const FeatureObservation& observation, FeatureAssociation& association) {
  const double log_pd = std::log(settings.association.detection_probability);
  for_gated_pairs<D>(
      settings.association.gate, pose, P, observation, association,
      [](const Detection&, const StoredLandmark&) { return true; },
      [&](std::size_t d, std::size_t n, double distance, double determinant) {
        const double log_signature =
            log_signature_likelihood(settings, observation.detections[d].signature,
                                     association.nearby[n].landmark.signature(), association.signature_distance_of_new);
        const double log_likelihood = log_pd + log_normal<D>(distance, determinant) + log_signature;
        if (log_likelihood >= log_p0)
          association.pairs.push_back({log_likelihood, log_signature, static_cast<int>(d), static_cast<int>(n)});
      });
}

bool knows(const LandmarkStore& store, int identity) {
  bool known = false;
  store.for_all([&](const StoredLandmark& landmark) { known = known || landmark.identity() == identity; });
  return known;
}

template <int D>
void associate_by_identity(const FeatureMapSettings& settings, const Eigen::Vector3d& pose, const Eigen::Matrix3d& P,
                           const FeatureObservation& observation, FeatureAssociation& association) {
  for_gated_pairs<D>(
      settings.association.identity_gate, pose, P, observation, association,
      [](const Detection& detection, const StoredLandmark& landmark) {
        return detection.identity >= 0 && detection.identity == landmark.identity();
      },
      [&](std::size_t d, std::size_t n, double distance, double determinant) {
        association.pairs.push_back(
            {log_normal<D>(distance, determinant), 0.0, static_cast<int>(d), static_cast<int>(n)});
      });
}

/// What a known identity leaves over: of an identity that the map does not know, the first detection is new.
void settle_identities(const LandmarkStore& store, const FeatureObservation& observation,
                       FeatureAssociation& association) {
  const auto& detections = observation.detections;
  for (std::size_t d = 0; d < detections.size(); ++d) {
    if (association.match[d].chunk >= 0) continue;
    const int identity = detections[d].identity;
    const bool repeated = std::any_of(detections.begin(), detections.begin() + static_cast<std::ptrdiff_t>(d),
                                      [&](const Detection& other) { return other.identity == identity; });
    if (identity < 0 || repeated || knows(store, identity)) association.match[d].chunk = FeatureAssociation::kAmbiguous;
  }
}

/// A likely identity of a landmark somewhere in the map makes no second one: the pose is off, or it was misread.
void reject_known_looks(const LandmarkStore& store, const FeatureObservation& observation,
                        FeatureAssociation& association) {
  constexpr float kLikely = 0.5f;
  for (std::size_t d = 0; d < observation.detections.size(); ++d) {
    const int identity = observation.detections[d].identity;
    if (association.match[d].chunk >= 0 || identity < 0) continue;
    bool known = false;
    store.for_all([&](const Landmark& landmark) {
      known = known || landmark.signature[static_cast<std::size_t>(identity)] > kLikely;
    });
    if (known) association.match[d].chunk = FeatureAssociation::kAmbiguous;
  }
}

}  // namespace

template <int D>
void associate(const LandmarkStore& store, const FeatureMapSettings& settings, double log_p0,
               const Eigen::Vector3d& pose, const Eigen::Matrix3d& P, const FeatureObservation& observation,
               FeatureAssociation& association) {
  association.pairs.clear();
  association.match.assign(observation.detections.size(), LandmarkRef{});
  if (settings.identity == IdentityUse::known) {
    associate_by_identity<D>(settings, pose, P, observation, association);
    match_greedily(association);
    settle_identities(store, observation, association);
    return;
  }
  collect_pairs<D>(settings, log_p0, pose, P, observation, association);
  switch (settings.association.method) {
    case AssociationMethod::greedy:
      match_greedily(association);
      break;
    case AssociationMethod::optimal:
      match_optimally(log_p0, association);
      break;
    case AssociationMethod::joint:
      match_jointly<D>(settings, log_p0, pose, P, observation, association);
      break;
  }
  if (settings.identity == IdentityUse::signature) reject_known_looks(store, observation, association);
}

template void associate<2>(const LandmarkStore&, const FeatureMapSettings&, double, const Eigen::Vector3d&,
                           const Eigen::Matrix3d&, const FeatureObservation&, FeatureAssociation&);
template void associate<3>(const LandmarkStore&, const FeatureMapSettings&, double, const Eigen::Vector3d&,
                           const Eigen::Matrix3d&, const FeatureObservation&, FeatureAssociation&);

}  // namespace waymark
