// SPDX-License-Identifier: Apache-2.0
#include "map_modules/feature_map/particle_feature_map.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "map_modules/feature_map/association/detection_model.hpp"
#include "map_modules/feature_map/association/likelihoods.hpp"
#include "map_modules/feature_map/association/pose_refinement.hpp"
#include "map_modules/feature_map/landmarks/existence.hpp"
#include "map_modules/feature_map/landmarks/landmark_file.hpp"
#include "map_modules/feature_map/landmarks/merging.hpp"
#include "map_modules/feature_map/landmarks/repeats.hpp"
#include "waymark/base/error.hpp"

namespace waymark::feature_map {

namespace {

/// The least covariance >= floor (in the sense of ⪰) that is not below P either.
Eigen::Matrix2d at_least(const Eigen::Matrix2d& P, const Eigen::Matrix2d& floor) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver;
  solver.computeDirect(P - floor);
  if (solver.eigenvalues().x() >= 0.0) return P;
  return floor +
         solver.eigenvectors() * solver.eigenvalues().cwiseMax(0.0).asDiagonal() * solver.eigenvectors().transpose();
}

/// (4.10) with a floor: q⁺(b) ∝ z(b) q(b), and no bin dies for ever. The floor is under the view too, or one that
/// shares no bin with those before would replace them all.
void multiply(Signature& q, const Signature& z, double floor) {
  const auto least = static_cast<float>(floor);
  float sum = 0.0f;
  for (std::size_t b = 0; b < q.size(); ++b) sum += q[b] *= std::max(z[b], least);
  for (float& bin : q) bin = std::max(bin / sum, least);
  sum = 0.0f;
  for (const float bin : q) sum += bin;
  for (float& bin : q) bin /= sum;
}

/// Mean of a Dirichlet distribution whose counts are the views: q⁺ = q + (z − q)/(n + 1) after n of them.
void average(Signature& q, const Signature& z, int views) {
  for (std::size_t b = 0; b < q.size(); ++b) q[b] += (z[b] - q[b]) / static_cast<float>(views + 1);
}

/// Names a detection, and the landmark that it makes. Detections of later scans have other names, for half a year.
std::uint64_t birth_of(const FeatureObservation& observation, std::size_t detection) {
  constexpr std::uint64_t kMostDetections = 1024;
  return static_cast<std::uint64_t>(observation.stamp.time_since_epoch().count()) * kMostDetections + detection + 1;
}

/// Fuses the signature of one detection; an unknown one changes nothing.
void fuse_signature(Landmark& landmark, const Signature& seen, const AssociationSettings& s) {
  if (seen.empty()) return;
  if (landmark.signature.empty()) {
    landmark.signature = seen;
  } else if (s.signature_fusion == SignatureFusion::dirichlet) {
    average(landmark.signature, seen, landmark.signature_views);
  } else {
    multiply(landmark.signature, seen, s.signature_floor);
  }
  ++landmark.signature_views;
}

}  // namespace

void ParticleFeatureMap::refine(const PoseGaussian& prior, const Pose&, const Observation& observation,
                                Refinement& out) const {
  if (!out.association) out.association = std::make_unique<FeatureAssociation>();
  auto& association = static_cast<FeatureAssociation&>(*out.association);
  const auto& features = static_cast<const FeatureObservation&>(observation);
  const double distance = signature_distance_sum_ / signature_distance_count_;
  if (settings_->use_radius) {
    associate_and_refine<3>(landmarks_, *settings_, distance, prior, features, association, out);
  } else {
    associate_and_refine<2>(landmarks_, *settings_, distance, prior, features, association, out);
  }
  out.writes = settings_->writes() && std::ranges::any_of(association.landmark_of, [](LandmarkRef ref) {
                 return ref.chunk != FeatureAssociation::kAmbiguous;
               });
}

void ParticleFeatureMap::learn_signature_distance(const Detection& detection, const FeatureAssociation& association,
                                                  LandmarkRef own) {
  if (std::isfinite(settings_->association.new_landmark_signature_distance)) return;  // the mean is not used
  if (detection.signature.empty()) return;
  for (const NearbyLandmarks::Entry& nearby : association.nearby) {
    const std::span<const float> other = landmarks_.stored(nearby.ref).signature();
    if (nearby.ref == own || other.empty()) continue;
    signature_distance_sum_ += signature_distance(detection.signature, other);
    signature_distance_count_ += 1.0;
  }
}

template <int D>
void ParticleFeatureMap::write_associated(const PoseGaussian& pose, const FeatureObservation& observation,
                                          const FeatureAssociation& association) {
  using Model = DetectionModel<D>;
  const Eigen::Vector3d xyyaw(pose.T_map_base.p.x(), pose.T_map_base.p.y(), pose.T_map_base.yaw());
  for (std::size_t d = 0; d < observation.detections.size(); ++d) {
    const Detection& detection = observation.detections[d];
    const LandmarkRef ref = association.landmark_of[d];
    if (ref.chunk == FeatureAssociation::kAmbiguous) continue;
    if (settings_->use_signature) learn_signature_distance(detection, association, ref);
    if (ref.chunk < 0) continue;

    // What sampling kept of the pose's covariance is common to all landmarks of the scan and to the next scans: it is
    // added to the noise, and the landmark can never be known better than the best pose it was written from.
    const Model model(detection, xyyaw);
    Landmark landmark = landmarks_.at(ref);
    const typename Model::PoseJacobian G = model.jacobian(landmark.mean.head<2>());
    const typename Model::Matrix kept = G * pose.P * G.transpose();
    const Eigen::Matrix2d floor = kept.template topLeftCorner<2, 2>();
    const typename Model::Matrix P = landmark.P.template topLeftCorner<D, D>();
    const typename Model::Matrix S = P + model.R + kept;
    const typename Model::Matrix K = P * S.inverse();
    landmark.mean.head<D>() += K * (model.z - landmark.mean.head<D>());
    typename Model::Matrix updated = P - K * S * K.transpose();
    updated = (0.5 * (updated + updated.transpose())).eval();
    if (floor.trace() < landmark.P_floor.trace()) landmark.P_floor = floor;
    updated.template topLeftCorner<2, 2>() = at_least(updated.template topLeftCorner<2, 2>(), landmark.P_floor);
    landmark.P.topLeftCorner<D, D>() = updated;
    landmark.last_seen = std::max(landmark.last_seen, observation.stamp);
    ++landmark.sightings;
    figures_.born += landmark.sightings == settings_->existence.min_observations;
    if (D == 2) {
      // The radius is not in the filter, but reports contain it: a running mean.
      landmark.mean.z() += (detection.xyr.z() - landmark.mean.z()) / landmark.sightings;
      landmark.P(2, 2) = settings_->noise.radius * settings_->noise.radius / landmark.sightings;
    }
    if (settings_->use_signature) fuse_signature(landmark, detection.signature, settings_->association);
    landmark.log_odds = log_odds_after_hit(landmark.log_odds, settings_->existence);
    landmarks_.write(ref, landmark);
    if (settings_->keep_sightings) sightings_.append({observation.stamp, detection.xyr.head<2>(), landmark.id, false});
  }
}

template <int D>
void ParticleFeatureMap::add_new(const PoseGaussian& pose, const FeatureObservation& observation,
                                 const FeatureAssociation& association) {
  using Model = DetectionModel<D>;
  const Eigen::Vector3d xyyaw(pose.T_map_base.p.x(), pose.T_map_base.p.y(), pose.T_map_base.yaw());
  for (std::size_t d = 0; d < observation.detections.size(); ++d) {
    if (association.landmark_of[d].chunk != FeatureAssociation::kNew) continue;
    const Detection& detection = observation.detections[d];
    const Model model(detection, xyyaw);
    const typename Model::PoseJacobian G = model.jacobian(model.z.template head<2>());
    const typename Model::Matrix kept = G * pose.P * G.transpose();
    Landmark landmark;
    landmark.mean.head<D>() = model.z;
    landmark.mean.z() = detection.xyr.z();
    landmark.P.topLeftCorner<D, D>() = model.R + kept;
    if (D == 2) landmark.P(2, 2) = settings_->noise.radius * settings_->noise.radius;
    landmark.P_floor = kept.template topLeftCorner<2, 2>();
    if (settings_->use_signature) fuse_signature(landmark, detection.signature, settings_->association);
    landmark.identity = detection.identity;
    landmark.birth = birth_of(observation, d);
    landmark.last_seen = observation.stamp;
    landmark.sightings = 1;
    figures_.born += settings_->existence.min_observations == 1;
    const std::int64_t id = landmarks_.add(landmark);
    if (settings_->keep_sightings) sightings_.append({observation.stamp, detection.xyr.head<2>(), id, true});
  }
}

void ParticleFeatureMap::count_misses(const FeatureAssociation& association) {
  const ExistenceSettings& existence = settings_->existence;
  for (const LandmarkRef ref : association.missed) {
    const StoredLandmark landmark = landmarks_.stored(ref);
    const float log_odds = log_odds_after_miss(landmark.log_odds(), existence);
    if (survives(log_odds, landmark.sightings(), existence)) {
      landmarks_.write_log_odds(ref, log_odds);
    } else {
      figures_.deleted += is_confirmed(landmark.sightings(), existence);
      landmarks_.erase(ref);
    }
  }
}

void ParticleFeatureMap::insert(const PoseGaussian& pose, const Observation& observation, const Association* memo) {
  const auto& features = static_cast<const FeatureObservation&>(observation);
  const auto& association = static_cast<const FeatureAssociation&>(*memo);
  figures_.associated += static_cast<std::uint64_t>(association.associated);
  figures_.ambiguous += static_cast<std::uint64_t>(association.ambiguous);
  if (!settings_->writes()) return;
  // The refs of the association hold until the first landmark is added, so adding comes last.
  if (settings_->use_radius) {
    write_associated<3>(pose, features, association);
  } else {
    write_associated<2>(pose, features, association);
  }
  count_misses(association);
  if (settings_->association.merge) {
    const MergeCounts counts = merge_neighbours(landmarks_, *settings_, association.landmark_of);
    figures_.merged += static_cast<std::uint64_t>(counts.merged);
    figures_.born += static_cast<std::uint64_t>(counts.confirmed);
  }
  if (settings_->use_radius) {
    add_new<3>(pose, features, association);
  } else {
    add_new<2>(pose, features, association);
  }
}

void ParticleFeatureMap::correspond(const Observation& observation, const Association* memo,
                                    Correspondences& out) const {
  const auto& features = static_cast<const FeatureObservation&>(observation);
  const auto& association = static_cast<const FeatureAssociation&>(*memo);
  for (std::size_t d = 0; d < features.detections.size(); ++d) {
    const LandmarkRef ref = association.landmark_of[d];
    if (ref.chunk == FeatureAssociation::kAmbiguous) continue;
    const Detection& detection = features.detections[d];
    const Eigen::Matrix2d R = detection.R.topLeftCorner<2, 2>();
    if (ref.chunk < 0) {
      out.landmarks.push_back({birth_of(features, d), true, detection.xyr.head<2>(), R});
      continue;
    }
    const StoredLandmark landmark = landmarks_.stored(ref);
    const double share = new_share(settings_->noise, landmark.last_seen(), features.stamp);
    out.landmarks.push_back({landmark.birth(), false, detection.xyr.head<2>(), R / share});
  }
}

void ParticleFeatureMap::describe(MapDescription& out) const {
  landmarks_.for_all([&](const Landmark& landmark) {
    LandmarkView view;
    view.id = landmark.id;
    view.birth = landmark.birth;
    view.p_map = landmark.mean.head<2>();
    view.radius_m = landmark.mean.z();
    view.P = landmark.P;
    view.existence = existence_probability(landmark.log_odds);
    view.sightings = landmark.sightings;
    view.confirmed = is_confirmed(landmark.sightings, settings_->existence);
    out.landmarks.push_back(view);
  });
  out.figures = {{"born", static_cast<double>(figures_.born)},
                 {"deleted", static_cast<double>(figures_.deleted)},
                 {"merged", static_cast<double>(figures_.merged)},
                 {"ambiguous_share", static_cast<double>(figures_.ambiguous) /
                                         static_cast<double>(std::max<std::uint64_t>(1, figures_.associated))}};
  out.sightings = sightings_.items();
}

std::vector<MapFile> ParticleFeatureMap::files(const Pose& T_enu_map) const {
  return {{".landmarks.yaml", landmark_file(landmarks_, T_enu_map)}};
}

template <class Archive>
void ParticleFeatureMap::serialize(Archive& archive) {
  const std::uint32_t version = archive.section("feature_map", 3);
  if (version >= 2) archive(figures_.born, figures_.deleted, figures_.merged, figures_.associated, figures_.ambiguous);
  archive(signature_distance_sum_);
  archive.within(signature_distance_count_, 1.0, std::numeric_limits<double>::max());
  archive(landmarks_);
  if constexpr (Archive::kReads) require_bins();
  if (version < 3) return;
  sightings_.serialize(archive, [](auto& each, Sighting& sighting) {
    each(sighting.stamp, sighting.p_base, sighting.landmark, sighting.is_first);
  });
}

void ParticleFeatureMap::require_bins() const {
  const std::size_t expected = settings_->signature_bins();
  landmarks_.for_all([&](StoredLandmark landmark) {
    const std::size_t bins = landmark.signature().size();
    if (expected != 0 && bins != 0 && bins != expected)
      throw DataError("checkpoint: landmarks: a signature with another number of bins");
  });
}

void ParticleFeatureMap::save(OutArchive& out) const { out(*this); }
void ParticleFeatureMap::load(InArchive& in) { in(*this); }

}  // namespace waymark::feature_map
