// SPDX-License-Identifier: Apache-2.0
#include "map_modules/feature_map/association/pose_refinement.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "map_modules/feature_map/association/ambiguity.hpp"
#include "map_modules/feature_map/association/association.hpp"
#include "map_modules/feature_map/association/detection_model.hpp"
#include "map_modules/feature_map/association/likelihoods.hpp"
#include "map_modules/feature_map/association/missed_landmarks.hpp"
#include "map_modules/feature_map/landmarks/existence.hpp"

namespace waymark::feature_map {

namespace {

/// Everything that may be associated or should be seen from about this pose.
void gather(const LandmarkStore& store, const FeatureMapSettings& settings, const PoseGaussian& prior,
            const FeatureObservation& observation, FeatureAssociation& association) {
  const double sigma =
      std::sqrt(prior.P(0, 0) + prior.P(1, 1) + prior.P(2, 2) * observation.max_range * observation.max_range);
  double reach = observation.max_range + 4.0 * sigma + 2.0;
  if (settings.use_negative_information)
    reach = std::max(reach, observation.view.p_base_sensor.norm() + settings.existence.view_range);
  association.nearby.gather(store, prior.T_map_base.p.head<2>(), reach);
}

/// Detections one after the other against the pose as the ones before have refined it.
template <int D>
class Refiner {
 public:
  using Model = DetectionModel<D>;

  Refiner(const LandmarkStore& store, const FeatureMapSettings& settings, double log_p0, const PoseGaussian& prior,
          const FeatureObservation& observation, FeatureAssociation& association, Refinement& out)
      : store_(store),
        settings_(settings),
        log_p0_(log_p0),
        log_pd_(std::log(settings.association.detection_probability)),
        observation_(observation),
        association_(association),
        out_(out),
        start_(prior.T_map_base.p.x(), prior.T_map_base.p.y(), prior.T_map_base.yaw()),
        pose_(start_),
        P_(prior.P) {}

  const Eigen::Vector3d& start() const { return start_; }

  /// The evidence of an associated detection, and its information unless it is ambiguous.
  void take(std::size_t d, bool refines) {
    const StoredLandmark landmark = store_.stored(association_.landmark_of[d]);
    const Comparison c = compare(d, landmark);
    // A provisional landmark may guide the pose, but it proves nothing yet.
    const bool proves = is_confirmed(landmark.sightings(), settings_.existence);
    out_.log_evidence += proves ? std::max(c.log_likelihood, log_p0_) : log_p0_;
    if (!refines) return;
    const typename Model::Matrix S_landmark_inverse = c.S_landmark.inverse();
    out_.information += c.H.transpose() * S_landmark_inverse * c.H;
    out_.gradient += c.H.transpose() * (S_landmark_inverse * (c.nu + c.H * (pose_ - start_)));
    const Eigen::Matrix<double, 3, D> K = P_ * c.H.transpose() * c.S_inverse;
    pose_ += K * c.nu;
    P_ -= K * c.S * K.transpose();
  }

  /// True if some other landmark is nearly as likely as the chosen one, by the pairs' likelihoods at the prior.
  bool is_ambiguous(std::size_t d) const {
    const Rivals rivals = rivals_of(d, association_, -std::numeric_limits<double>::infinity());
    return rivals.other > rivals.chosen - settings_.association.log_min_likelihood_ratio;
  }

  /// Decides about an ambiguous detection again, at the refined pose: true if its landmark is clear now.
  bool is_clear_now(std::size_t d) const {
    const double chosen = compare(d, store_.stored(association_.landmark_of[d])).log_likelihood;
    return std::ranges::none_of(association_.pairs, [&](const FeatureAssociation::Pair& pair) {
      const NearbyLandmarks::Entry& nearby = association_.nearby[static_cast<std::size_t>(pair.nearby)];
      if (static_cast<std::size_t>(pair.detection) != d || nearby.ref == association_.landmark_of[d]) return false;
      return compare(d, nearby.landmark).log_likelihood > chosen - settings_.association.log_min_likelihood_ratio;
    });
  }

  Pose refined(const Pose& T_map_base) const {
    Pose refined = T_map_base;
    refined.p.head<2>() = pose_.template head<2>();
    refined.q = (so3::exp({0.0, 0.0, pose_.z() - start_.z()}) * refined.q).normalized();
    return refined;
  }

 private:
  struct Comparison {
    typename Model::Vector nu;
    typename Model::PoseJacobian H;
    typename Model::Matrix S_landmark;
    typename Model::Matrix S;
    typename Model::Matrix S_inverse;
    double log_likelihood;  ///< of place and signature
  };

  Comparison compare(std::size_t d, const StoredLandmark& landmark) const {
    const Model model(observation_.detections[d], pose_);
    const Eigen::Vector3d mean = landmark.mean();
    Comparison c;
    c.nu = model.z - mean.head<D>();
    c.H = model.jacobian(mean.head<2>());
    c.S_landmark = landmark.covariance().template topLeftCorner<D, D>() + model.R;
    c.S = c.H * P_ * c.H.transpose() + c.S_landmark;
    c.S_inverse = c.S.inverse();
    c.log_likelihood = log_pd_ + log_normal<D>(c.nu.dot(c.S_inverse * c.nu), c.S.determinant());
    c.log_likelihood += log_signature_likelihood(settings_, observation_.detections[d].signature, landmark.signature(),
                                                 association_.signature_distance_of_new);
    return c;
  }

  const LandmarkStore& store_;
  const FeatureMapSettings& settings_;
  double log_p0_;
  double log_pd_;
  const FeatureObservation& observation_;
  FeatureAssociation& association_;
  Refinement& out_;
  Eigen::Vector3d start_;
  Eigen::Vector3d pose_;
  Eigen::Matrix3d P_;
};

}  // namespace

template <int D>
void associate_and_refine(const LandmarkStore& store, const FeatureMapSettings& settings,
                          double mean_signature_distance, const PoseGaussian& prior,
                          const FeatureObservation& observation, FeatureAssociation& association, Refinement& out) {
  const double log_p0 = log_new_landmark(settings, mean_signature_distance);
  association.signature_distance_of_new = new_landmark_signature_distance(settings, mean_signature_distance);
  gather(store, settings, prior, observation, association);
  Refiner<D> refiner(store, settings, log_p0, prior, observation, association, out);
  associate<D>(store, settings, log_p0, refiner.start(), prior.P, observation, association);
  count_ambiguous(log_p0, association);

  const bool requires_ratio = settings.association.log_min_likelihood_ratio > 0.0;
  association.undecided.clear();
  for (std::size_t d = 0; d < observation.detections.size(); ++d) {
    // What looked at nothing has no density of looks: both p₀ and p_v hold the same share, which differs from particle
    // to particle and must not weigh them.
    if (settings.use_signature && observation.detections[d].signature.empty())
      out.log_evidence += settings.association.signature_lambda * association.signature_distance_of_new;
    if (association.landmark_of[d].chunk < 0) {
      out.log_evidence += log_p0;
    } else if (requires_ratio && refiner.is_ambiguous(d)) {
      association.undecided.push_back(d);
    } else {
      refiner.take(d, true);
    }
  }
  for (const std::size_t d : association.undecided) {
    const bool clear = refiner.is_clear_now(d);
    refiner.take(d, clear);
    if (!clear) association.landmark_of[d].chunk = FeatureAssociation::kAmbiguous;
  }

  const Pose refined = refiner.refined(prior.T_map_base);
  if (settings.identity == IdentityUse::unused) reject_doubtful_new(settings, refined, observation, association);
  out.log_evidence += find_missed(settings, refined, observation, association);
}

template void associate_and_refine<2>(const LandmarkStore&, const FeatureMapSettings&, double, const PoseGaussian&,
                                      const FeatureObservation&, FeatureAssociation&, Refinement&);
template void associate_and_refine<3>(const LandmarkStore&, const FeatureMapSettings&, double, const PoseGaussian&,
                                      const FeatureObservation&, FeatureAssociation&, Refinement&);

}  // namespace waymark::feature_map
