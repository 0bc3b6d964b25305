// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "map_modules/octomap_grid/voxel_tile.hpp"
#include "map_modules/shared/scan_matching/scan_matcher.hpp"
#include "map_modules/shared/scan_matching/tiled_cells.hpp"
#include "waymark/math/pose.hpp"

namespace waymark::octomap_grid {

/// What one layer of a map has in one tile.
struct LayerTile {
  const std::uint8_t* distances;
  const VoxelOctree* voxels;
};

/// One layer of a map around a scan, as a field that points are matched on.
class LayerField : public scan_matching::TiledCells<VoxelOctree::kBits> {
 public:
  LayerField(const TileRect& rect, std::int32_t z, std::span<const LayerTile> tiles)
      : TiledCells(rect), z_(z), tiles_(tiles) {}

  bool is_known(int x, int y) const {
    constexpr int kMask = VoxelOctree::kSide - 1;
    const auto local = [](int cell) { return static_cast<std::uint8_t>(cell & kMask); };
    return tiles_[slot(x, y)].voxels->find({local(x), local(y), local(z_)}) != nullptr;
  }
  std::uint8_t distance(int x, int y) const { return *distances_at(x, y); }
  const std::uint8_t* distances_at(int x, int y) const { return tiles_[slot(x, y)].distances + Slab::place(x, y); }

 private:
  std::int32_t z_;
  std::span<const LayerTile> tiles_;
};

/// A scan over one particle's map: every point over the layer that it lies in. Height, roll and pitch are those of the
/// prior's mean, so x, y and yaw do not move a point from layer to layer. Kept from scan to scan for its storage.
class LayeredTarget final : public scan_matching::MatchTarget {
 public:
  /// Looks at the tiles within `reach` [m] of the base. `points` are in the base frame. Throws Error if that is no
  /// place for a map.
  void open(const VoxelMap& map, const Pose& T_map_base, double reach, std::span<const Eigen::Vector3f> points,
            double resolution);

  scan_matching::FieldFit fit(const scan_matching::LikelihoodTable& table, const Eigen::Vector3d& xyyaw) const override;
  double sum_likelihood(const scan_matching::LikelihoodTable& table, const Eigen::Vector3d& xyyaw,
                        double least) const override;
  double blocked_share(const Eigen::Vector3d& xyyaw, scan_matching::Ends ends) const override;

 private:
  struct Layer {
    std::int32_t z;
    std::size_t first;  // of its points
    std::size_t end;
  };
  struct Levelled {
    std::int32_t z;
    Eigen::Vector2f p;
  };

  void find_tiles();
  LayerField field(std::size_t layer) const {
    return {rect_, layers_[layer].z, std::span(tiles_).subspan(layer * rect_.size(), rect_.size())};
  }
  std::span<const Eigen::Vector2f> points(const Layer& layer) const {
    return std::span(points_).subspan(layer.first, layer.end - layer.first);
  }

  TileRect rect_;
  double resolution_ = 1.0;
  std::vector<const TileColumn*> columns_;
  std::vector<std::size_t> layer_at_;  // per height from the lowest on
  std::vector<LayerTile> tiles_;       // per layer and column
  std::vector<Levelled> levelled_;
  std::vector<Layer> layers_;
  std::vector<Eigen::Vector2f> points_;  // in the base's place, but level; layer by layer
};

}  // namespace waymark::octomap_grid
