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

/// The distances of one layer of a map around a scan, as a field that points are matched on.
class LayerField : public scan_matching::TiledCells<VoxelOctree::kBits> {
 public:
  LayerField(const TileRect& rect, std::span<const std::uint8_t* const> slabs) : TiledCells(rect), slabs_(slabs) {}

  std::uint8_t distance(int x, int y) const { return *distances_at(x, y); }
  const std::uint8_t* distances_at(int x, int y) const { return slabs_[slot(x, y)] + Slab::place(x, y); }

 private:
  std::span<const std::uint8_t* const> slabs_;
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
  double unknown_share(const Eigen::Vector3d& /*xyyaw*/) const override { return 0.0; }

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

  void find_slabs();
  LayerField field(std::size_t layer) const {
    return {rect_, std::span(slabs_).subspan(layer * rect_.size(), rect_.size())};
  }
  std::span<const Eigen::Vector2f> points(const Layer& layer) const {
    return std::span(points_).subspan(layer.first, layer.end - layer.first);
  }

  TileRect rect_;
  double resolution_ = 1.0;
  std::vector<const TileColumn*> columns_;
  std::vector<std::size_t> layer_at_;       // per height from the lowest on
  std::vector<const std::uint8_t*> slabs_;  // per layer and column
  std::vector<Levelled> levelled_;
  std::vector<Layer> layers_;
  std::vector<Eigen::Vector2f> points_;  // in the base's place, but level; layer by layer
};

}  // namespace waymark::octomap_grid
