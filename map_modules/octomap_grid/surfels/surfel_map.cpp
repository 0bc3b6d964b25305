// SPDX-License-Identifier: Apache-2.0
#include "map_modules/octomap_grid/surfels/surfel_map.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "waymark/base/error.hpp"

namespace waymark::octomap_grid {

using scan_matching::TileIndex;
using scan_matching::TileRect;

namespace {

/// So far from the origin cells can lie.
constexpr double kMostCells = double{TileIndex::kMost} * SurfelTile::kSide;

}  // namespace

void SurfelAddition::sort(std::span<const Eigen::Vector3f> points, const Pose& T_map_base, double cell) {
  points_.clear();
  points_.reserve(points.size());
  const Eigen::Matrix3d R = T_map_base.q.toRotationMatrix();
  for (const Eigen::Vector3f& point : points) {
    const Eigen::Vector3d p = R * point.cast<double>() + T_map_base.p;
    const Eigen::Vector3d at = (p / cell).array().floor();
    if (!(at.cwiseAbs().maxCoeff() < kMostCells)) throw Error("the scan lies outside of what a grid can hold");
    const Eigen::Vector3i index = at.cast<std::int32_t>();
    const Eigen::Vector3d middle = (at.array() + 0.5) * cell;
    points_.push_back({{index.x() >> SurfelTile::kBits, index.y() >> SurfelTile::kBits},
                       static_cast<std::uint32_t>(SurfelTile::column(index.x(), index.y())),
                       index.z(),
                       (p - middle).cast<float>()});
  }
  // Stable: a sum of floats depends on the order.
  std::ranges::stable_sort(points_, {}, [](const Point& p) { return std::tuple(p.tile.x, p.tile.y, p.column, p.z); });
}

void SurfelAddition::write(SurfelTree& tree, double cell) {
  auto point = points_.begin();
  while (point != points_.end()) {
    const TileIndex tile = point->tile;
    additions_.clear();
    for (; point != points_.end() && point->tile == tile; ++point) {
      const bool is_next =
          additions_.empty() || additions_.back().column != point->column || additions_.back().surfel.z != point->z;
      if (is_next) {
        additions_.push_back({point->column, {}});
        additions_.back().surfel.z = point->z;
      }
      additions_.back().surfel.add(point->p);
    }
    if (tree.read(tile).takes(additions_)) tree.write(tile).add(additions_, static_cast<float>(cell));
  }
}

void SurfelMap::add(std::span<const Eigen::Vector3f> points, const Pose& T_map_base, double cell,
                    SurfelAddition& scratch) {
  for (int i = 0; i < kLevels; ++i) {
    scratch.sort(points, T_map_base, cell_of(i, cell));
    scratch.write(levels_[static_cast<std::size_t>(i)], cell_of(i, cell));
  }
}

void SurfelMap::describe(std::vector<MapFigure>& out) const {
  std::size_t planes = 0;
  levels_[0].for_all([&](TileIndex, const SurfelTile& tile, bool) {
    planes += static_cast<std::size_t>(std::ranges::count_if(tile.surfels(), &Surfel::is_plane));
  });
  std::size_t bytes = 0;
  for (const SurfelTree& tree : levels_) {
    const std::array<const SurfelTree*, 1> own{&tree};
    bytes += SurfelTree::bytes_of(own);
  }
  out.push_back({"surfels", static_cast<double>(planes)});
  out.push_back({"surfel_bytes", static_cast<double>(bytes)});
}

void SurfelWindow::open(const SurfelTree& tree, double cell, const Eigen::Vector3d& center, double reach) {
  cell_ = cell;
  const Eigen::Vector2d middle = center.head<2>();
  const double beyond = reach + cell;
  rect_ = TileRect::around(middle.array() - beyond, middle.array() + beyond, cell * SurfelTile::kSide);
  if (!((std::abs(center.z()) + beyond) / cell < kMostCells))
    throw Error("the scan lies outside of what a grid can hold");
  tiles_.resize(rect_.size());
  tree.gather(rect_, tiles_);
}

SurfelWindow::Plane SurfelWindow::nearest(const Eigen::Vector3d& p) const {
  const Eigen::Vector3d low = (p / cell_ - Eigen::Vector3d::Constant(0.5)).array().floor();
  Plane best{nullptr, Eigen::Vector3d::Zero()};
  if (!(low.cwiseAbs().maxCoeff() < kMostCells)) return best;  // a step that went astray
  const Eigen::Vector3i first = low.cast<std::int32_t>();
  double best_distance = std::numeric_limits<double>::infinity();
  for (std::int32_t y = first.y(); y <= first.y() + 1; ++y) {
    const std::int32_t tile_y = (y >> SurfelTile::kBits) - rect_.low.y;
    if (tile_y < 0 || tile_y >= rect_.height()) continue;
    for (std::int32_t x = first.x(); x <= first.x() + 1; ++x) {
      const std::int32_t tile_x = (x >> SurfelTile::kBits) - rect_.low.x;
      if (tile_x < 0 || tile_x >= rect_.width()) continue;
      const auto slot =
          static_cast<std::size_t>(tile_y) * static_cast<std::size_t>(rect_.width()) + static_cast<std::size_t>(tile_x);
      const SurfelTile& tile = *tiles_[slot];
      if (tile.size() == 0) continue;
      const std::size_t column = SurfelTile::column(x, y);
      for (std::int32_t z = first.z(); z <= first.z() + 1; ++z) {
        const Surfel* const surfel = tile.find(column, z);
        if (surfel == nullptr || !surfel->is_plane()) continue;
        const Eigen::Vector3d middle =
            (Eigen::Vector3d(x, y, z).array() + 0.5).matrix() * cell_ + surfel->middle.cast<double>();
        const double distance = (p - middle).squaredNorm();
        if (distance >= best_distance) continue;
        best_distance = distance;
        best = {surfel, middle};
      }
    }
  }
  return best;
}

}  // namespace waymark::octomap_grid
