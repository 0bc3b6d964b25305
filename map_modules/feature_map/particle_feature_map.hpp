// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>

#include "map_modules/feature_map/association/feature_association.hpp"
#include "map_modules/feature_map/feature_map_settings.hpp"
#include "map_modules/feature_map/feature_observation.hpp"
#include "map_modules/feature_map/landmarks/landmark_store.hpp"
#include "waymark/memory/lineage.hpp"

namespace waymark::feature_map {

/// One particle's map of augmented landmarks.
class ParticleFeatureMap final : public ParticleMap {
 public:
  explicit ParticleFeatureMap(std::shared_ptr<const FeatureMapSettings> settings, LandmarkStore landmarks = {})
      : settings_(std::move(settings)), landmarks_(std::move(landmarks)) {}

  std::unique_ptr<ParticleMap> clone() const override { return std::make_unique<ParticleFeatureMap>(*this); }
  void refine(const PoseGaussian& prior, const Pose& start, const Observation& observation,
              Refinement& out) const override;
  void insert(const PoseGaussian& pose, const Observation& observation, const Association* association) override;
  void correspond(const Observation& observation, const Association* association, Correspondences& out) const override;
  void describe(MapDescription& out) const override;
  std::vector<MapFile> files(const Pose& T_enu_map) const override;
  void save(OutArchive& out) const override;
  void load(InArchive& in);
  template <class Archive>
  void serialize(Archive& archive);

  const LandmarkStore& landmarks() const { return landmarks_; }

 private:
  template <int D>
  void write_associated(const PoseGaussian& pose, const FeatureObservation& observation,
                        const FeatureAssociation& association);
  void count_misses(const FeatureAssociation& association);
  template <int D>
  void add_new(const PoseGaussian& pose, const FeatureObservation& observation, const FeatureAssociation& association);
  /// Throws DataError if a landmark's signature has other bins than the settings.
  void require_bins() const;
  void learn_signature_distance(const Detection& detection, const FeatureAssociation& association, LandmarkRef own);

  /// What has happened to this map and its ancestors.
  struct Figures {
    std::uint64_t born = 0;     ///< confirmed for the first time
    std::uint64_t deleted = 0;  ///< confirmed ones that were removed
    std::uint64_t merged = 0;
    std::uint64_t associated = 0;  ///< detections with a landmark
    std::uint64_t ambiguous = 0;
  };

  std::shared_ptr<const FeatureMapSettings> settings_;
  LandmarkStore landmarks_;
  Lineage<Sighting> sightings_;  // empty unless `keep_sightings`
  Figures figures_;
  // Running mean of D between detections and *other* landmarks: what a chance match looks like (p₀).
  double signature_distance_sum_ = 0.5;
  double signature_distance_count_ = 1.0;
};

}  // namespace waymark::feature_map
