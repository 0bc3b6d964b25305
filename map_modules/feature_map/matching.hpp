// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <span>
#include <vector>

#include "association_workspace.hpp"
#include "feature_map_settings.hpp"
#include "feature_observation.hpp"
#include "landmark_store.hpp"
#include "nearby_landmarks.hpp"

namespace waymark {

/// Which landmark each detection belongs to, in one particle; with the scratch space that makes the next step free of
/// allocation.
class FeatureAssociation final : public Association {
 public:
  static constexpr std::int32_t kNew = -1;        ///< `chunk` of a detection that makes a new landmark
  static constexpr std::int32_t kAmbiguous = -2;  ///< too close to a landmark that it does not match: neither

  std::vector<LandmarkRef> match;   ///< per detection; chunk kNew or kAmbiguous where there is none
  std::vector<LandmarkRef> missed;  ///< landmarks that should have been seen

  struct Pair {
    double log_likelihood;  ///< of place and signature
    double log_signature;   ///< its part of the signature
    int detection;
    int nearby;
  };
  std::vector<float> missed_log_odds;  ///< of those that are confirmed
  NearbyLandmarks nearby;
  std::vector<Pair> pairs;                 ///< detections and landmarks that fit
  double signature_distance_of_new = 0.0;  ///< D in p₀
  std::vector<std::size_t> undecided;      ///< detections for which another landmark is nearly as likely
  int matched = 0;                         ///< detections with a landmark
  int ambiguous = 0;                       ///< of those: another landmark, or none, was at least a tenth as likely
  AssociationWorkspace workspace;
};

/// One detection against one landmark: ν = z_map − θ and its Jacobian by the pose, D = 2 (position) or 3 (with radius).
/// The detection is turned into the map frame, so the landmark's Jacobian is the identity.
template <int D>
struct DetectionModel {
  using Vector = Eigen::Matrix<double, D, 1>;
  using Matrix = Eigen::Matrix<double, D, D>;
  using PoseJacobian = Eigen::Matrix<double, D, 3>;

  Vector z;  ///< detection in the map frame, seen from the pose
  Matrix R;  ///< its noise in the map frame
  Eigen::Vector2d p_map_base;

  DetectionModel(const Detection& detection, const Eigen::Vector3d& pose);

  /// ∂h/∂(x, y, yaw) for a landmark or detection at `p_map`.
  PoseJacobian jacobian(const Eigen::Vector2d& p_map) const;
};

/// log N(ν; 0, S) out of νᵀ S⁻¹ ν and |S|.
template <int D>
double log_normal(double squared_mahalanobis, double determinant) {
  constexpr double kLogTwoPi = 1.8378770664093453;
  return -0.5 * (squared_mahalanobis + std::log(determinant) + D * kLogTwoPi);
}

/// log of the new-landmark likelihood p₀: a density over the observation's space.
double log_new_landmark(const FeatureMapSettings& settings, double mean_signature_distance);

/// D of (4.7), 1 − Σ √(a b): the squared Hellinger distance, 0..1.
double signature_distance(const Signature& a, const Signature& b);
double signature_distance(const Signature& a, std::span<const float> b);

/// D of a landmark that is none of the map's: as configured, or else the mean that was learnt.
double new_landmark_signature_distance(const FeatureMapSettings& settings, double mean_signature_distance);

/// log p_v of (4.7), −λ D; 0 where the map uses no signatures. If the detection's or the landmark's signature is
/// unknown, D is that of a new landmark, so that the pair is neither likelier nor less likely for it.
double log_signature_likelihood(const FeatureMapSettings& settings, const Signature& detection,
                                std::span<const float> landmark, double distance_of_new);

/// Associates (association.hpp), refines the pose by every associated
/// detection in turn, and collects the log evidence of all observations and misses (estimation.md §3.2, §3.4, "Every
/// observation counts").
template <int D>
void match_and_refine(const LandmarkStore& store, const FeatureMapSettings& settings, double mean_signature_distance,
                      const PoseGaussian& prior, const FeatureObservation& observation, FeatureAssociation& association,
                      Refinement& out);

}  // namespace waymark
