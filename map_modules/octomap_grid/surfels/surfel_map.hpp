// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "map_modules/octomap_grid/surfels/surfel_tile.hpp"
#include "waymark/interface/particle_map.hpp"
#include "waymark/math/pose.hpp"

namespace waymark::octomap_grid {

/// Storage that adding a scan takes; one of these serves many scans, not thread-safe.
class SurfelAddition {
 public:
  /// Sorts points [m, in the map] into cells of one size.
  void sort(std::span<const Eigen::Vector3f> points, const Pose& T_map_base, double cell);
  /// Adds them. Throws Error if they lie outside of what a map can hold.
  void write(SurfelTree& tree, double cell);

 private:
  struct Point {
    scan_matching::TileIndex tile;
    std::uint32_t column;
    std::int32_t z;
    Eigen::Vector3f p;  // from the cell's middle
  };
  std::vector<Point> points_;
  std::vector<SurfelTile::Addition> additions_;
};

/// What a scan is matched to in six degrees of freedom: surfels (small planes) in cells of three sizes, the larger ones
/// for the basin, the smallest for the precision. After the normal distributions transform (M. Magnusson, *The
/// Three-Dimensional Normal-Distributions Transform*, 2009), of whose distributions only the planes are used. Copies
/// share their tiles.
class SurfelMap {
 public:
  static constexpr int kLevels = 3;
  /// Side of the cells of a level, if the smallest have `cell` [m].
  static double cell_of(int level, double cell) { return cell * (1 << level); }

  bool empty() const { return levels_[0].empty(); }
  const SurfelTree& level(int level) const { return levels_[static_cast<std::size_t>(level)]; }
  /// Adds end points [m, in the base frame]. Throws Error if they lie outside of what a map can hold.
  void add(std::span<const Eigen::Vector3f> points, const Pose& T_map_base, double cell, SurfelAddition& scratch);
  void describe(std::vector<MapFigure>& out) const;
  template <class Archive>
  void serialize(Archive& archive) {
    archive(levels_);
  }

 private:
  std::array<SurfelTree, kLevels> levels_;
};

/// One level of surfels around a scan.
class SurfelWindow {
 public:
  /// `reach` [m]: around the position `center`. Throws Error if that is not a place for a map.
  void open(const SurfelTree& tree, double cell, const Eigen::Vector3d& center, double reach);
  double cell() const { return cell_; }

  struct Plane {
    const Surfel* surfel;
    Eigen::Vector3d middle;  ///< in the map [m]
  };
  /// Of the planes in the eight cells that are nearest to `p` [m, in the map] the one whose middle is nearest; null if
  /// there is none.
  Plane nearest(const Eigen::Vector3d& p) const;

 private:
  double cell_ = 1.0;
  scan_matching::TileRect rect_{};
  std::vector<const SurfelTile*> tiles_;
};

}  // namespace waymark::octomap_grid
