// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "map_modules/octomap_grid/cloud_observation.hpp"
#include "map_modules/octomap_grid/octomap_grid_settings.hpp"
#include "map_modules/octomap_grid/surfels/surfel_map.hpp"
#include "map_modules/octomap_grid/voxel_tile.hpp"
#include "map_modules/shared/scan_matching/last_written.hpp"
#include "map_modules/shared/scan_matching/match_record.hpp"
#include "map_modules/shared/scan_matching/scan_matcher.hpp"
#include "waymark/interface/particle_map.hpp"

namespace waymark::octomap_grid {

/// What all particles' maps have in common.
struct OctomapModel {
  /// Loads the map that the settings name. Throws DataError if it is not a valid map.
  explicit OctomapModel(OctomapGridSettings s);

  OctomapGridSettings settings;
  scan_matching::ScanMatcher matcher;
  VoxelMap initial;           ///< what every map begins with
  SurfelMap initial_surfels;  ///< those of the same map, where planes are matched
};

/// One particle's map of voxels.
class ParticleOctomap final : public ParticleMap {
 public:
  explicit ParticleOctomap(std::shared_ptr<const OctomapModel> model)
      : model_(std::move(model)), voxels_(model_->initial), surfels_(model_->initial_surfels) {}

  std::unique_ptr<ParticleMap> clone() const override { return std::make_unique<ParticleOctomap>(*this); }
  void refine(const PoseGaussian& prior, const Pose& start, const Observation& observation,
              Refinement& out) const override;
  void insert(const PoseGaussian& pose, const Observation& observation, const Association* association) override;
  void correspond(const Observation& observation, const Association* association, Correspondences& out) const override;
  void describe(MapDescription& out) const override;
  std::optional<GridView> grid() const override;
  std::vector<MapFile> files(const Pose& T_enu_map) const override;
  void save(OutArchive& out) const override;
  void load(InArchive& in);
  template <class Archive>
  void serialize(Archive& archive);

  const VoxelMap& voxels() const { return voxels_; }

 private:
  void refine_on_planes(const PoseGaussian& prior, const Pose& start, const CloudObservation& cloud,
                        scan_matching::MatchAssociation& association, Refinement& out) const;
  /// Where the tree lies: not at the map's origin if it was loaded.
  const Pose& T_map_tree() const { return model_->settings.load.T_map_file; }
  /// To the bit the same pose, if no map was loaded.
  Pose in_tree(const Pose& T_map_base) const {
    return model_->settings.load.file.empty() ? T_map_base : T_map_tree().inverse() * T_map_base;
  }
  /// As in the flat grid: where nothing comes back, nothing ties the pose to the map.
  bool writes(const CloudObservation& cloud) const {
    return model_->settings.load.use != map_formats::MapUse::localize && !cloud.hits.empty();
  }

  std::shared_ptr<const OctomapModel> model_;
  VoxelMap voxels_;
  SurfelMap surfels_;  // empty, unless planes are matched
  scan_matching::LastWritten last_written_;
  scan_matching::MatchRecord record_;
};

}  // namespace waymark::octomap_grid
