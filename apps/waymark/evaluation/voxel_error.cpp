// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/evaluation/voxel_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "apps/waymark/maps/octree_file.hpp"
#include "waymark/base/error.hpp"

namespace waymark::evaluation {

namespace {

constexpr double kMostVoxels = 10.0;  // that the tolerance may reach over

double share(std::uint64_t part, std::uint64_t whole) {
  return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : std::numeric_limits<double>::quiet_NaN();
}

double to_nearest(const std::vector<Surface>& surfaces, const Eigen::Vector3d& p) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Surface& surface : surfaces) nearest = std::min(nearest, distance(surface, p));
  return nearest;
}

/// What the map has near a point.
enum class Near { nothing, free, occupied };

Near look_near(const octomap::OcTree& tree, const Eigen::Vector3d& p, double tolerance_m) {
  const double side = tree.getResolution();
  const Eigen::Vector3i center = (p / side).array().floor().cast<int>();
  const auto reach = static_cast<int>(std::ceil(tolerance_m / side));
  Near found = Near::nothing;
  for (int x = -reach; x <= reach; ++x) {
    for (int y = -reach; y <= reach; ++y) {
      for (int z = -reach; z <= reach; ++z) {
        const Eigen::Vector3d middle = (center.cast<double>() + Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5)) * side;
        const bool is_own = x == 0 && y == 0 && z == 0;
        if (!is_own && (middle - p).norm() > tolerance_m) continue;
        octomap::OcTreeKey key;
        if (!tree.coordToKeyChecked(middle.x(), middle.y(), middle.z(), key)) continue;
        const octomap::OcTreeNode* node = tree.search(key);
        if (node == nullptr) continue;
        if (tree.isNodeOccupied(node)) return Near::occupied;
        found = Near::free;
      }
    }
  }
  return found;
}

}  // namespace

double VoxelError::precision() const { return share(right, occupied); }
double VoxelError::recall() const { return share(found, found + missed); }

VoxelError score_voxels(const std::filesystem::path& octree, const std::vector<Surface>& surfaces,
                        const VoxelOptions& options) {
  const maps::LoadedOctree loaded = maps::read_octree(octree);
  const octomap::OcTree& tree = *loaded.tree;
  const maps::OctreeFigures figures = maps::figures_of(tree);
  if (figures.occupied == 0) throw DataError(fmt::format("{}: no voxel is occupied", octree.string()));
  const double side = tree.getResolution();
  VoxelError error;
  error.tolerance_m = options.tolerance_m > 0.0 ? options.tolerance_m : side;

  if (error.tolerance_m > kMostVoxels * side) {
    throw Error(fmt::format("evaluate: --voxel-tolerance-m {}: at most {:g} voxels of {} m are expected",
                            error.tolerance_m, kMostVoxels, side));
  }

  std::vector<double> distances;
  distances.reserve(figures.occupied);
  for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf) {
    if (!tree.isNodeOccupied(*leaf)) continue;
    const maps::VoxelBox box = maps::box_of(leaf, tree);
    for (int x = box.low[0]; x < box.high[0]; ++x) {
      for (int y = box.low[1]; y < box.high[1]; ++y) {
        for (int z = box.low[2]; z < box.high[2]; ++z)
          distances.push_back(to_nearest(surfaces, Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5) * side));
      }
    }
  }
  error.occupied = distances.size();
  error.right =
      static_cast<std::uint64_t>(std::ranges::count_if(distances, [&](double d) { return d <= error.tolerance_m; }));
  error.distance_m = statistics(std::move(distances));

  const Region region{Eigen::Vector3d::Map(figures.low_m.data()), Eigen::Vector3d::Map(figures.high_m.data())};
  for (const Surface& surface : surfaces) {
    for_points_on(surface, region, side, [&](const Eigen::Vector3d& p) {
      const Near near = look_near(tree, p, error.tolerance_m);
      ++error.points;
      error.found += near == Near::occupied ? 1 : 0;
      error.missed += near == Near::free ? 1 : 0;
    });
  }
  return error;
}

}  // namespace waymark::evaluation
