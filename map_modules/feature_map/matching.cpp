// SPDX-License-Identifier: Apache-2.0
#include "matching.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "association.hpp"
#include "visibility.hpp"

namespace waymark {

namespace {

/// Everything that may match or should be seen from about this pose.
void gather(const LandmarkStore& store, const FeatureMapSettings& settings, const PoseGaussian& prior,
            const FeatureObservation& observation, FeatureAssociation& association) {
  const double sigma =
      std::sqrt(prior.P(0, 0) + prior.P(1, 1) + prior.P(2, 2) * observation.max_range * observation.max_range);
  double reach = observation.max_range + 4.0 * sigma + 2.0;
  if (settings.use_negative_information)
    reach = std::max(reach, observation.view.p_base_sensor.norm() + settings.existence.view_range);
  association.nearby.gather(store, prior.T_map_base.p.head<2>(), reach);
}

/// Landmarks that should have been seen from the refined pose but were not; returns their log factor.
double judge_misses(const FeatureMapSettings& settings, const Pose& T_map_base, const FeatureObservation& observation,
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
    if (landmark.sightings() >= settings.existence.min_observations)
      association.missed_log_odds.push_back(landmark.log_odds());
  }
  // Only so many count: the most certain ones, whatever the order in which they are stored.
  std::vector<float>& counted = association.missed_log_odds;
  std::ranges::sort(counted, std::ranges::greater{});
  const std::size_t most = std::min(counted.size(), static_cast<std::size_t>(settings.existence.max_misses));
  double log_factor = 0.0;
  for (std::size_t i = 0; i < most; ++i) {
    const double existence = 1.0 / (1.0 + std::exp(-static_cast<double>(counted[i])));
    log_factor += std::log1p(-settings.association.detection_probability * existence);
  }
  return log_factor;
}

/// How likely a matched detection is with its landmark and with the likeliest other one, at least `least` each.
struct Rivals {
  double chosen;
  double other;
};

Rivals rivals_of(std::size_t detection, const FeatureAssociation& association, double least) {
  Rivals rivals{least, least};
  for (const FeatureAssociation::Pair& pair : association.pairs) {
    if (static_cast<std::size_t>(pair.detection) != detection) continue;
    const LandmarkRef ref = association.nearby[static_cast<std::size_t>(pair.nearby)].ref;
    double& likelihood = ref == association.match[detection] ? rivals.chosen : rivals.other;
    likelihood = std::max(likelihood, pair.log_likelihood);
  }
  return rivals;
}

/// Counts matched detections, and those of them that nearly had another landmark or none.
void count_ambiguous(double log_p0, FeatureAssociation& association) {
  constexpr double kLogTen = 2.302585092994046;
  association.matched = 0;
  association.ambiguous = 0;
  for (std::size_t d = 0; d < association.match.size(); ++d) {
    if (association.match[d].chunk < 0) continue;
    const Rivals rivals = rivals_of(d, association, log_p0);
    ++association.matched;
    association.ambiguous += rivals.other > rivals.chosen - kLogTen;
  }
}

/// A detection that fits no landmark but lies closer to one than two landmarks can stand is an outlier of that one, a
/// double echo, or a glimpse of its neighbour: a new landmark there would compete with the old one from now on. Nor
/// does a candidate make one that the camera has not confirmed.
void mark_ambiguous(const FeatureMapSettings& settings, const Pose& T_map_base, const FeatureObservation& observation,
                    FeatureAssociation& association) {
  const double separation = settings.association.min_separation;
  for (std::size_t d = 0; d < observation.detections.size(); ++d) {
    if (association.match[d].chunk != FeatureAssociation::kNew) continue;
    if (!observation.detections[d].may_be_new) {
      association.match[d].chunk = FeatureAssociation::kAmbiguous;
      continue;
    }
    const Eigen::Vector3d& xyr = observation.detections[d].xyr;
    const Eigen::Vector2d p = (T_map_base * Eigen::Vector3d(xyr.x(), xyr.y(), 0.0)).head<2>();
    const auto near = association.nearby.within(p, separation * separation, 0.0);
    const bool close = std::ranges::any_of(near, [&](std::uint32_t n) {
      return (association.nearby[n].landmark.mean().head<2>() - p).squaredNorm() < separation * separation;
    });
    if (close) association.match[d].chunk = FeatureAssociation::kAmbiguous;
  }
}

}  // namespace

template <int D>
DetectionModel<D>::DetectionModel(const Detection& detection, const Eigen::Vector3d& pose)
    : p_map_base(pose.head<2>()) {
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(pose.z()).toRotationMatrix();
  z.template head<2>() = p_map_base + turn * detection.xyr.head<2>();
  R.template topLeftCorner<2, 2>() = turn * detection.R.topLeftCorner<2, 2>() * turn.transpose();
  if constexpr (D == 3) {
    z[2] = detection.xyr.z();
    R.template topRightCorner<2, 1>() = turn * detection.R.topRightCorner<2, 1>();
    R.template bottomLeftCorner<1, 2>() = R.template topRightCorner<2, 1>().transpose();
    R(2, 2) = detection.R(2, 2);
  }
}

template <int D>
typename DetectionModel<D>::PoseJacobian DetectionModel<D>::jacobian(const Eigen::Vector2d& p_map) const {
  const Eigen::Vector2d d = p_map - p_map_base;
  PoseJacobian H = PoseJacobian::Zero();
  H(0, 0) = -1.0;
  H(1, 1) = -1.0;
  H(0, 2) = d.y();
  H(1, 2) = -d.x();
  return H;
}

double signature_distance(const Signature& a, const Signature& b) {
  return signature_distance(a, std::span<const float>(b.begin(), b.size()));
}

double signature_distance(const Signature& a, std::span<const float> b) {
  double overlap = 0.0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    overlap += std::sqrt(static_cast<double>(a[i]) * static_cast<double>(b[i]));
  return std::max(0.0, 1.0 - overlap);
}

double log_new_landmark(const FeatureMapSettings& settings, double mean_signature_distance) {
  double log_p0 = std::log(settings.association.new_landmark_density);
  if (settings.use_radius) log_p0 -= std::log(settings.association.radius_range);
  if (settings.use_signature) {
    log_p0 -=
        settings.association.signature_lambda * new_landmark_signature_distance(settings, mean_signature_distance);
  }
  return log_p0;
}

double new_landmark_signature_distance(const FeatureMapSettings& settings, double mean_signature_distance) {
  const double fixed = settings.association.new_landmark_signature_distance;
  return std::isfinite(fixed) ? fixed : mean_signature_distance;
}

double log_signature_likelihood(const FeatureMapSettings& settings, const Signature& detection,
                                std::span<const float> landmark, double distance_of_new) {
  if (!settings.use_signature) return 0.0;
  const bool unknown = detection.empty() || landmark.empty();
  return -settings.association.signature_lambda * (unknown ? distance_of_new : signature_distance(detection, landmark));
}

namespace {

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

  /// The evidence of a matched detection, and its information unless it is ambiguous.
  void take(std::size_t d, bool refines) {
    const StoredLandmark landmark = store_.stored(association_.match[d]);
    const Comparison c = compare(d, landmark);
    // A provisional landmark may guide the pose, but it proves nothing yet.
    const bool proves = landmark.sightings() >= settings_.existence.min_observations;
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

  /// Decides about an ambiguous detection again, at the refined pose: true if its match is clear now.
  bool is_clear_now(std::size_t d) const {
    const double chosen = compare(d, store_.stored(association_.match[d])).log_likelihood;
    return std::ranges::none_of(association_.pairs, [&](const FeatureAssociation::Pair& pair) {
      const NearbyLandmarks::Entry& nearby = association_.nearby[static_cast<std::size_t>(pair.nearby)];
      if (static_cast<std::size_t>(pair.detection) != d || nearby.ref == association_.match[d]) return false;
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
void match_and_refine(const LandmarkStore& store, const FeatureMapSettings& settings, double mean_signature_distance,
                      const PoseGaussian& prior, const FeatureObservation& observation, FeatureAssociation& association,
                      Refinement& out) {
  const double log_p0 = log_new_landmark(settings, mean_signature_distance);
  association.signature_distance_of_new = new_landmark_signature_distance(settings, mean_signature_distance);
  gather(store, settings, prior, observation, association);
  Refiner<D> refiner(store, settings, log_p0, prior, observation, association, out);
  associate<D>(store, settings, log_p0, refiner.start(), prior.P, observation, association);
  count_ambiguous(log_p0, association);

  const bool asks_for_ratio = settings.association.log_min_likelihood_ratio > 0.0;
  association.undecided.clear();
  for (std::size_t d = 0; d < observation.detections.size(); ++d) {
    // What looked at nothing has no density of looks: both p₀ and p_v hold the same share, which differs from particle
    // to particle and must not weigh them.
    if (settings.use_signature && observation.detections[d].signature.empty())
      out.log_evidence += settings.association.signature_lambda * association.signature_distance_of_new;
    if (association.match[d].chunk < 0) {
      out.log_evidence += log_p0;
    } else if (asks_for_ratio && refiner.is_ambiguous(d)) {
      association.undecided.push_back(d);
    } else {
      refiner.take(d, true);
    }
  }
  for (const std::size_t d : association.undecided) {
    const bool clear = refiner.is_clear_now(d);
    refiner.take(d, clear);
    if (!clear) association.match[d].chunk = FeatureAssociation::kAmbiguous;
  }

  const Pose refined = refiner.refined(prior.T_map_base);
  if (settings.identity == IdentityUse::unused) mark_ambiguous(settings, refined, observation, association);
  out.log_evidence += judge_misses(settings, refined, observation, association);
}

template struct DetectionModel<2>;
template struct DetectionModel<3>;
template void match_and_refine<2>(const LandmarkStore&, const FeatureMapSettings&, double, const PoseGaussian&,
                                  const FeatureObservation&, FeatureAssociation&, Refinement&);
template void match_and_refine<3>(const LandmarkStore&, const FeatureMapSettings&, double, const PoseGaussian&,
                                  const FeatureObservation&, FeatureAssociation&, Refinement&);

}  // namespace waymark
