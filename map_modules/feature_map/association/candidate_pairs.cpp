// SPDX-License-Identifier: Apache-2.0
#include "map_modules/feature_map/association/candidate_pairs.hpp"

#include <Eigen/LU>
#include <cmath>

#include "map_modules/feature_map/association/detection_model.hpp"
#include "map_modules/feature_map/association/likelihoods.hpp"

namespace waymark::feature_map {

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

}  // namespace

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
          association.pairs.push_back({log_likelihood, static_cast<int>(d), static_cast<int>(n)});
      });
}

template <int D>
void collect_identity_pairs(const FeatureMapSettings& settings, const Eigen::Vector3d& pose, const Eigen::Matrix3d& P,
                            const FeatureObservation& observation, FeatureAssociation& association) {
  for_gated_pairs<D>(
      settings.association.identity_gate, pose, P, observation, association,
      [](const Detection& detection, const StoredLandmark& landmark) {
        return detection.identity >= 0 && detection.identity == landmark.identity();
      },
      [&](std::size_t d, std::size_t n, double distance, double determinant) {
        association.pairs.push_back({log_normal<D>(distance, determinant), static_cast<int>(d), static_cast<int>(n)});
      });
}

template void collect_pairs<2>(const FeatureMapSettings&, double, const Eigen::Vector3d&, const Eigen::Matrix3d&,
                               const FeatureObservation&, FeatureAssociation&);
template void collect_pairs<3>(const FeatureMapSettings&, double, const Eigen::Vector3d&, const Eigen::Matrix3d&,
                               const FeatureObservation&, FeatureAssociation&);
template void collect_identity_pairs<2>(const FeatureMapSettings&, const Eigen::Vector3d&, const Eigen::Matrix3d&,
                                        const FeatureObservation&, FeatureAssociation&);
template void collect_identity_pairs<3>(const FeatureMapSettings&, const Eigen::Vector3d&, const Eigen::Matrix3d&,
                                        const FeatureObservation&, FeatureAssociation&);

}  // namespace waymark::feature_map
