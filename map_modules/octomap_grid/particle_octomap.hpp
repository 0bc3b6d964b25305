// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "cloud_observation.hpp"
#include "match_record.hpp"
#include "octomap_grid_settings.hpp"
#include "scan_matching.hpp"
#include "voxel_tile.hpp"
#include "waymark/interface/map_module.hpp"

namespace waymark::octo {

/// What all particles' maps have in common.
struct OctomapModel {
  /// Loads the map that the settings name. Throws DataError if it is no good.
  explicit OctomapModel(OctomapGridSettings s);

  OctomapGridSettings settings;
  grid::ScanMatcher matcher;
  VoxelMap initial;  ///< what every map begins with
};

/// One particle's map of voxels.
class ParticleOctomap final : public ParticleMap {
 public:
  explicit ParticleOctomap(std::shared_ptr<const OctomapModel> model)
      : model_(std::move(model)), voxels_(model_->initial) {}

  std::unique_ptr<ParticleMap> clone() const override { return std::make_unique<ParticleOctomap>(*this); }
  void refine(const PoseGaussian& prior, const Pose& start, const Observation& observation,
              Refinement& out) const override;
  void insert(const PoseGaussian& pose, const Observation& observation, const Association* association) override;
  void describe(MapDescription& out) const override;
  std::optional<GridView> grid() const override;
  std::vector<MapFile> files(const Pose& T_enu_map) const override;
  void save(OutArchive& out) const override;
  void load(InArchive& in);

  const VoxelMap& voxels() const { return voxels_; }

 private:
  /// As in the flat grid: where nothing comes back, nothing ties the pose to the map.
  bool writes(const CloudObservation& cloud) const {
    return model_->settings.load.use != grid::MapUse::localize && !cloud.hits.empty();
  }

  std::shared_ptr<const OctomapModel> model_;
  VoxelMap voxels_;
  grid::MatchRecord record_;
};

}  // namespace waymark::octo
