// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>

#include "occupancy_grid_settings.hpp"
#include "scan_matching.hpp"
#include "tile_tree.hpp"
#include "waymark/map_module.hpp"

namespace waymark::grid {

/// What all particles' grids have in common.
struct GridModel {
  explicit GridModel(OccupancyGridSettings s) : settings(std::move(s)), matcher(settings.match, settings.resolution) {}

  OccupancyGridSettings settings;
  ScanMatcher matcher;
};

/// How a scan matched one particle's grid, for its figures.
struct GridAssociation final : Association {
  enum class Outcome : std::uint8_t { not_tried, matched, failed };
  Outcome outcome = Outcome::not_tried;
  bool searched = false;
  double score = 0.0;
};

/// One particle's occupancy grid.
class ParticleGrid final : public ParticleMap {
 public:
  explicit ParticleGrid(std::shared_ptr<const GridModel> model, TileTree tiles = {})
      : model_(std::move(model)), tiles_(std::move(tiles)) {}

  std::unique_ptr<ParticleMap> clone() const override { return std::make_unique<ParticleGrid>(*this); }
  void refine(const PoseGaussian& prior, const Pose& start, const Observation& observation,
              Refinement& out) const override;
  void insert(const PoseGaussian& pose, const Observation& observation, const Association* association) override;
  void describe(MapDescription& out) const override;
  void save(OutArchive& out) const override;
  void load(InArchive& in);

  const TileTree& tiles() const { return tiles_; }

 private:
  /// What has happened to this map and its ancestors.
  struct Figures {
    std::uint64_t matches = 0;
    std::uint64_t failed = 0;
    std::uint64_t searches = 0;
    double score_sum = 0.0;  // of the matches
  };

  std::shared_ptr<const GridModel> model_;
  TileTree tiles_;
  Figures figures_;
};

}  // namespace waymark::grid
