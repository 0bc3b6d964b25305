// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "survey.hpp"
#include "waymark/interface/particle_map.hpp"
#include "waymark/memory/cow.hpp"

namespace waymark::range_beacons {

/// One particle's map: where the radio beacons stand, each named by its number, and the scale of their ranges.
class BeaconMap final : public ParticleMap {
 public:
  explicit BeaconMap(const Settings& settings);
  std::unique_ptr<ParticleMap> clone() const override { return std::make_unique<BeaconMap>(*this); }

  void refine(const PoseGaussian& prior, const Pose& start, const Observation& observation,
              Refinement& out) const override;
  void insert(const PoseGaussian& pose, const Observation& observation, const Association* association) override;
  void describe(MapDescription& out) const override;
  void save(OutArchive& out) const override;
  void load(InArchive& in);

 private:
  /// A beacon of which there is a range: still a ring, or a place of the survey.
  struct Beacon {
    int number = -1;
    int index = -1;  ///< in the survey; negative: it is a ring
    std::int32_t sightings = 0;
    std::int32_t misses = 0;  ///< ranges in a row that do not fit
    Ring ring;

    template <class Archive>
    void serialize(Archive& archive) {
      archive(number, index, sightings, misses, ring);
    }
  };
  struct Content {
    Survey survey;
    std::vector<Cow<Beacon>> beacons;  ///< in the order of their first ranges
  };
  /// What a range says, before it is used.
  struct Prediction {
    double log_evidence;  ///< outliers included
    double trust;         ///< probability that it is no outlier
  };

  const Cow<Beacon>* find(int number) const;
  Prediction predict(const Beacon& beacon, const RangeSet::One& range, const Antenna& antenna,
                     const Eigen::Matrix3d& pose_P) const;
  void add(const RangeSet::One& range, const Antenna& antenna, const Eigen::Matrix3d& pose_P);
  void settle(Beacon& beacon, const Eigen::Vector2d& p_map_antenna);

  Settings settings_;
  Cow<Content> content_;
};

}  // namespace waymark::range_beacons
