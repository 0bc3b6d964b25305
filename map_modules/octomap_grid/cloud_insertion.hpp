// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "map_modules/octomap_grid/cloud_observation.hpp"
#include "map_modules/octomap_grid/column_window.hpp"
#include "waymark/math/pose.hpp"

namespace waymark::octomap_grid {

/// Writes scans into a map. Holds the storage that this takes, so one of these serves many scans; not thread-safe.
class CloudInsertion {
 public:
  /// Every voxel once per scan: those that hold an end point take a hit, those that a beam passes before its end, and
  /// that hold no end point, a miss. Only tiles where something changes are written. Throws Error if the scan lies
  /// outside of what a map can hold.
  void insert(VoxelMap& map, const Pose& T_map_base, const CloudObservation& cloud,
              const OctomapGridSettings& settings);

 private:
  using Voxels = Eigen::Vector3d;  // in voxels of the box

  void open(VoxelMap& map, const OctomapGridSettings& settings);
  VoxelOctree::Marks& marks(std::int32_t x, std::int32_t y, std::int32_t z);
  bool mark_end(const Voxels& end);
  template <int kMajor>
  void mark_beam_along(const Voxels& from, const Voxels& to);
  void mark_beam(const Voxels& from, const Voxels& to);
  void apply(std::size_t touched, const VoxelOdds& odds);

  struct Touched {
    std::size_t column = 0;  // slot in the window
    std::int32_t z = 0;      // tile
    VoxelOctree::Marks marks;
  };

  ColumnWindow window_;
  std::int32_t low_z_ = 0;           // tile
  std::size_t levels_ = 0;           // tiles above one another
  std::vector<std::int32_t> slots_;  // per tile of the box: place in touched_, or kUntouched
  bool keeps_layers_ = true;         // distances for matches of x, y and yaw
  std::vector<Touched> touched_;     // the first n_touched_ count
  std::size_t n_touched_ = 0;
  std::vector<Voxels> hits_;
  std::vector<Voxels> clear_to_;
  std::vector<LocalVoxel> tile_occupied_;
  std::vector<LocalVoxel> tile_freed_;
  std::vector<LayerCell> freed_;
  std::vector<LayerCell> occupied_;
  DistanceUpdate distances_;
};

}  // namespace waymark::octomap_grid
