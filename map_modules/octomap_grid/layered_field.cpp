// SPDX-License-Identifier: Apache-2.0
#include "map_modules/octomap_grid/layered_field.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "waymark/base/error.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::octomap_grid {

namespace {

/// Unknown, and nothing occupied is near.
LayerTile no_tile() {
  static const Slab slab;
  static const VoxelOctree voxels;
  return {slab.distance.data(), &voxels};
}

}  // namespace

void LayeredTarget::open(const VoxelMap& map, const Pose& T_map_base, double reach,
                         std::span<const Eigen::Vector3f> points, double resolution) {
  resolution_ = resolution;
  const Eigen::Vector2d center = T_map_base.p.head<2>();
  rect_ = TileRect::around(center.array() - reach, center.array() + reach, resolution_ * Slab::kSide);
  columns_.resize(rect_.size());
  map.gather(rect_, columns_);
  constexpr double kMost = double{TileIndex::kMost} * Slab::kSide;
  if (!((std::abs(T_map_base.p.z()) + reach) / resolution_ < kMost))
    throw Error("the scan lies outside of what a grid can hold");

  const Eigen::Matrix3d R_level_base =
      so3::from_rpy(0.0, 0.0, -T_map_base.yaw()).toRotationMatrix() * T_map_base.q.toRotationMatrix();
  levelled_.clear();
  for (const Eigen::Vector3f& point : points) {
    const Eigen::Vector3d p = R_level_base * point.cast<double>();
    const double z = std::floor((p.z() + T_map_base.p.z()) / resolution_);
    levelled_.push_back({static_cast<std::int32_t>(z), p.head<2>().cast<float>()});
  }
  std::ranges::stable_sort(levelled_, {}, &Levelled::z);
  points_.clear();
  layers_.clear();
  for (const Levelled& one : levelled_) {
    if (layers_.empty() || layers_.back().z != one.z) layers_.push_back({one.z, points_.size(), points_.size()});
    points_.push_back(one.p);
    layers_.back().end = points_.size();
  }
  find_tiles();
}

/// Column by column: most have no tile in most of the layers.
void LayeredTarget::find_tiles() {
  tiles_.assign(layers_.size() * rect_.size(), no_tile());
  if (layers_.empty()) return;
  const std::int32_t lowest = layers_.front().z;
  const std::int32_t highest = layers_.back().z;
  constexpr std::size_t kNoLayer = std::numeric_limits<std::size_t>::max();
  layer_at_.assign(static_cast<std::size_t>(highest - lowest) + 1, kNoLayer);
  for (std::size_t i = 0; i < layers_.size(); ++i) layer_at_[static_cast<std::size_t>(layers_[i].z - lowest)] = i;
  for (std::size_t slot = 0; slot < columns_.size(); ++slot) {
    columns_[slot]->for_all([&](std::int32_t tile_z, const VoxelTile& tile, bool) {
      const std::int32_t first = tile_z * Slab::kSide;
      const std::int32_t end = std::min(first + Slab::kSide, highest + 1);
      for (std::int32_t z = std::max(first, lowest); z < end; ++z) {
        const std::size_t layer = layer_at_[static_cast<std::size_t>(z - lowest)];
        if (layer == kNoLayer) continue;
        LayerTile& here = tiles_[layer * rect_.size() + slot];
        here.voxels = &tile.voxels;
        if (const Slab* slab = tile.slab(z)) here.distances = slab->distance.data();
      }
    });
  }
}

scan_matching::FieldFit LayeredTarget::fit(const scan_matching::LikelihoodTable& table,
                                           const Eigen::Vector3d& xyyaw) const {
  scan_matching::FieldSums sums;
  for (std::size_t i = 0; i < layers_.size(); ++i)
    sums = scan_matching::add_points(sums, field(i), table, points(layers_[i]), xyyaw, resolution_);
  return sums.fit(resolution_);
}

double LayeredTarget::sum_likelihood(const scan_matching::LikelihoodTable& table, const Eigen::Vector3d& xyyaw,
                                     double least) const {
  double sum = 0.0;
  auto left = static_cast<double>(points_.size());
  for (std::size_t i = 0; i < layers_.size(); ++i) {
    const std::span<const Eigen::Vector2f> own = points(layers_[i]);
    left -= static_cast<double>(own.size());
    sum += scan_matching::sum_likelihood(field(i), table, own, xyyaw, resolution_, least - sum - left);
  }
  return sum;
}

double LayeredTarget::blocked_share(const Eigen::Vector3d& xyyaw, scan_matching::Ends ends) const {
  std::size_t blocked = 0;
  for (std::size_t i = 0; i < layers_.size(); ++i)
    blocked += scan_matching::count_blocked(field(i), points(layers_[i]), xyyaw, resolution_, ends);
  return points_.empty() ? 0.0 : static_cast<double>(blocked) / static_cast<double>(points_.size());
}

}  // namespace waymark::octomap_grid
