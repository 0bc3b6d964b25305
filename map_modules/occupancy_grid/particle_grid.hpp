// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>

#include "map_modules/occupancy_grid/occupancy_grid_settings.hpp"
#include "map_modules/occupancy_grid/scan_observation.hpp"
#include "map_modules/occupancy_grid/tile_tree.hpp"
#include "map_modules/shared/scan_matching/last_written.hpp"
#include "map_modules/shared/scan_matching/match_record.hpp"
#include "map_modules/shared/scan_matching/scan_matcher.hpp"
#include "waymark/interface/particle_map.hpp"

namespace waymark::occupancy_grid {

/// What all particles' grids have in common.
struct GridModel {
  /// Loads the map that the settings name. Throws ConfigError or DataError if it is not a valid map.
  explicit GridModel(OccupancyGridSettings s);

  OccupancyGridSettings settings;
  scan_matching::ScanMatcher matcher;
  TileTree initial;  ///< what every map begins with
  Pose T_map_grid;   ///< planar: the corner of cell (0, 0), and how the cells are turned
};

/// One particle's occupancy grid.
class ParticleGrid final : public ParticleMap {
 public:
  explicit ParticleGrid(std::shared_ptr<const GridModel> model) : model_(std::move(model)), tiles_(model_->initial) {}

  std::unique_ptr<ParticleMap> clone() const override { return std::make_unique<ParticleGrid>(*this); }
  void refine(const PoseGaussian& prior, const Pose& start, const Observation& observation,
              Refinement& out) const override;
  void insert(const PoseGaussian& pose, const Observation& observation, const Association* association) override;
  std::unique_ptr<ParticleMap> blank() const override;
  void take_figures(const ParticleMap& of) override { record_ = static_cast<const ParticleGrid&>(of).record_; }
  void correspond(const Observation& observation, const Association* association, Correspondences& out) const override;
  void describe(MapDescription& out) const override;
  std::optional<GridView> grid() const override;
  void save(OutArchive& out) const override;
  void load(InArchive& in);
  template <class Archive>
  void serialize(Archive& archive);

  const TileTree& tiles() const { return tiles_; }

 private:
  /// Where nothing comes back, nothing ties the pose to the map: the free space would be written at an arbitrary pose.
  bool writes(const ScanObservation& scan) const {
    return model_->settings.load.use != map_formats::MapUse::localize && !scan.hits.empty();
  }
  /// x, y from the corner of cell (0, 0) [m], and yaw, along the cells.
  Eigen::Vector3d in_grid(const Pose& T_map_base) const {
    const Pose T_grid_base = model_->T_map_grid.inverse() * T_map_base;
    return {T_grid_base.p.x(), T_grid_base.p.y(), T_grid_base.yaw()};
  }

  std::shared_ptr<const GridModel> model_;
  TileTree tiles_;
  scan_matching::LastWritten last_written_;
  scan_matching::MatchRecord record_;
};

}  // namespace waymark::occupancy_grid
