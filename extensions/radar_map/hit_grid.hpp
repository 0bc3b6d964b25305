// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "waymark/interface/particle_map.hpp"
#include "waymark/memory/cow.hpp"

namespace waymark::radar_map {

/// Targets of one scan that stand still, in the base frame.
struct StillTargets : Observation {
  std::vector<Eigen::Vector2d> points_base;  ///< [m]
};

/// One particle's map: how often targets lay in each cell. A radar looks through what a laser stops at, so a target
/// says nothing about the cells before it. Tiles are shared between particles until one of them writes.
class HitGrid : public ParticleMap {
 public:
  /// `hit`: probability that a target shows something that stands there.
  HitGrid(double resolution_m, double hit) : resolution_m_(resolution_m), hit_(hit) {}

  std::unique_ptr<ParticleMap> clone() const override { return std::make_unique<HitGrid>(*this); }
  /// The map does not localise.
  void refine(const PoseGaussian&, const Pose&, const Observation&, Refinement&) const override {}
  void insert(const PoseGaussian& pose, const Observation& observation, const Association*) override;
  void describe(MapDescription& out) const override;
  std::optional<GridView> grid() const override;
  void save(OutArchive& out) const override;
  /// Throws DataError if the archive holds no such map.
  void load(InArchive& in);

 private:
  static constexpr int kSide = 32;  // cells of a tile's side
  using Tile = std::array<std::uint16_t, kSide * kSide>;
  using Place = std::pair<std::int32_t, std::int32_t>;  // row and column of a tile
  using Tiles = std::map<Place, Cow<Tile>>;

  double resolution_m_;
  double hit_;
  Cow<Tiles> tiles_;
};

}  // namespace waymark::radar_map
