// SPDX-License-Identifier: Apache-2.0
// needs plugins: occupancy_grid
#include "map_modules/octomap_grid/cloud_insertion.hpp"

#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <vector>

#include "map_modules/occupancy_grid/scan_insertion.hpp"
#include "tests/unit/map_modules/occupancy_grid/simulated_room.hpp"
#include "tests/unit/map_modules/octomap_grid/simulated_hall.hpp"

namespace waymark::octomap_grid_test {
namespace {

using scan_matching::StoredDistance;

const std::vector<Pose> kPoses = {
    {so3::from_rpy(0.02, -0.03, 0.3), {0.1, 0.2, 0.1}},
    {so3::from_rpy(-0.05, 0.04, -2.0), {-1.9, 1.0, 0.3}},
    {so3::from_rpy(0.0, 0.0, 1.7), {3.5, -1.4, 0.0}},
    {so3::from_rpy(0.1, 0.0, 3.0), {1.2, 0.4, 0.7}},
};

std::map<Voxel, float> voxels_of(const VoxelMap& map) {
  std::map<Voxel, float> all;
  for_all_leaves(map, [&](Voxel v, int side, float odds) {
    for (int i = 0; i < side * side * side; ++i)
      all[{v.x + i % side, v.y + i / side % side, v.z + i / (side * side)}] = odds;
  });
  return all;
}

/// What a planar scanner writes is what the flat grid writes: same cells, same odds, same distances.
TEST(CloudInsertion, OfAPlanarScanIsThatOfTheFlatGrid) {
  const occupancy_grid::OccupancyGridSettings flat_settings = occupancy_grid_test::settings();
  const OctomapGridSettings s = settings("{ resolution_m: 0.05 }");
  occupancy_grid::TileTree flat;
  VoxelMap map;
  occupancy_grid::ScanInsertion flat_insertion;
  CloudInsertion insertion;
  std::mt19937 random(11);
  std::normal_distribution<double> error(0.0, 1.0);
  const std::vector<Eigen::Vector3d> poses = {{0, 0, 0.3}, {-2, 1, -2.0}, {4.5, -2, 1.7}, {1.2, 0.4, 3.0}};
  for (int i = 0; i < 40; ++i) {
    const Eigen::Vector3d& pose = poses[static_cast<std::size_t>(i) % poses.size()];
    const LaserScan scan =
        occupancy_grid_test::scan_of(occupancy_grid_test::room(), pose, 0.02, static_cast<std::uint32_t>(i));
    const Eigen::Vector3d at = pose + Eigen::Vector3d(0.05 * error(random), 0.05 * error(random), 0.01 * error(random));
    flat_insertion.insert(flat, at, occupancy_grid::observe(scan, Pose{}, {}, flat_settings.scan), flat_settings);
    insertion.insert(map, Pose::planar(at.x(), at.y(), at.z()), observe(scan, Pose{}, {}, s), s);
  }
  const std::map<Voxel, float> voxels = voxels_of(map);
  std::size_t known = 0;
  std::size_t different = 0;
  flat.for_all([&](scan_matching::TileIndex index, const occupancy_grid::Tile& tile, bool) {
    for (int i = 0; i < static_cast<int>(occupancy_grid::Tile::kCells); ++i) {
      const std::int8_t odds = tile.odds[static_cast<std::size_t>(i)];
      const Cell cell{index.x * occupancy_grid::Tile::kSide + i % occupancy_grid::Tile::kSide,
                      index.y * occupancy_grid::Tile::kSide + i / occupancy_grid::Tile::kSide};
      const auto it = voxels.find({cell.x, cell.y, 0});
      const bool is_known = occupancy_grid::Tile::is_known(odds);
      known += is_known;
      // A point on the border of two cells may fall either way, since the windows of the two begin elsewhere.
      different += is_known != (it != voxels.end()) || (is_known && std::abs(20.0f * it->second - odds) > 0.01f);
      const VoxelTile* there = map.read({tile_of(cell.x), tile_of(cell.y)}).find(0);
      const Slab* slab = there == nullptr ? nullptr : there->slab(0);
      const int distance = slab == nullptr ? StoredDistance::kFar : slab->distance[Slab::place(cell.x, cell.y)];
      different += distance != tile.distances[static_cast<std::size_t>(i)];
    }
  });
  EXPECT_GT(known, 15'000U);
  EXPECT_EQ(known, voxels.size());
  EXPECT_LE(different, known / 1000);
}

/// Against OctoMap's own insertion of the same cloud: the same end points, and free is what is free there. OctoMap
/// marks every voxel that a beam touches, this one those that it passes about in the middle.
TEST(CloudInsertion, FindsWhatOctoMapsOwnInsertionFinds) {
  const OctomapGridSettings s = settings("{ log_odds: { hit: 0.85, miss: -0.4, min: -2, max: 3.5 } }");
  for (const Pose& T_map_base : kPoses) {
    const CloudObservation seen = observed(Hall(), T_map_base, tilted(), s);
    VoxelMap map;
    CloudInsertion().insert(map, T_map_base, seen, s);
    const std::map<Voxel, float> ours = voxels_of(map);

    octomap::OcTree tree(s.resolution);
    octomap::Pointcloud cloud;
    for (const Eigen::Vector3f& p : seen.hits) {
      const Eigen::Vector3f p_map = (T_map_base * p.cast<double>()).cast<float>();
      cloud.push_back(p_map.x(), p_map.y(), p_map.z());
    }
    const Eigen::Vector3f origin = (T_map_base * seen.p_base_sensor).cast<float>();
    octomap::KeySet free;
    octomap::KeySet hit;
    tree.computeUpdate(cloud, {origin.x(), origin.y(), origin.z()}, free, hit, -1.0);
    const auto key_of = [](Voxel v) {
      const auto part = [](std::int32_t i) { return static_cast<octomap::key_type>(i + 32768); };
      return octomap::OcTreeKey(part(v.x), part(v.y), part(v.z));
    };
    std::size_t our_hits = 0;
    std::size_t our_free = 0;
    std::size_t stray = 0;
    for (const auto& [voxel, odds] : ours) {
      const bool is_hit = odds > 0.0f;
      EXPECT_FLOAT_EQ(odds, is_hit ? 0.85f : -0.4f);
      (is_hit ? our_hits : our_free) += 1;
      // Coordinates are rounded differently, so a few on borders lie beside.
      stray += (is_hit ? hit : free).count(key_of(voxel)) == 0;
    }
    EXPECT_NEAR(static_cast<double>(our_hits), static_cast<double>(hit.size()),
                0.002 * static_cast<double>(hit.size()));
    EXPECT_GT(our_hits, 2000U);
    EXPECT_LT(stray, ours.size() / 100);
    EXPECT_GT(our_free, free.size() / 2);
  }
}

/// Squared distances within a box of voxels, as a table: a tree of as many takes minutes under sanitizers.
class Distances {
 public:
  Distances(const Voxel& low, const Voxel& high)
      : low_(low), nx_(high.x - low.x + 1), ny_(high.y - low.y + 1), squares_(size_of(low, high), kNone) {}

  static constexpr int kNone = -1;
  /// kNone outside of the box, too.
  int at(const Voxel& v) const {
    const std::ptrdiff_t i = index(v);
    return i < 0 ? kNone : squares_[static_cast<std::size_t>(i)];
  }
  void lower(const Voxel& v, int square) {
    int& known = squares_.at(static_cast<std::size_t>(index(v)));
    if (known == kNone || square < known) known = square;
  }
  std::size_t size() const {
    return static_cast<std::size_t>(std::ranges::count_if(squares_, [](int square) { return square != kNone; }));
  }

 private:
  static std::size_t size_of(const Voxel& low, const Voxel& high) {
    return static_cast<std::size_t>(high.x - low.x + 1) * static_cast<std::size_t>(high.y - low.y + 1) *
           static_cast<std::size_t>(high.z - low.z + 1);
  }
  std::ptrdiff_t index(const Voxel& v) const {
    const int x = v.x - low_.x;
    const int y = v.y - low_.y;
    const int z = v.z - low_.z;
    if (x < 0 || y < 0 || z < 0 || x >= nx_ || y >= ny_) return -1;
    const std::ptrdiff_t i = (static_cast<std::ptrdiff_t>(z) * ny_ + y) * nx_ + x;
    return i < static_cast<std::ptrdiff_t>(squares_.size()) ? i : -1;
  }

  Voxel low_;
  int nx_;
  int ny_;
  std::vector<int> squares_;
};

/// The distance in each layer to the nearest occupied voxel of that layer, over all pairs.
void expect_exact_distances(const VoxelMap& map) {
  constexpr int kReach = StoredDistance::kReach;
  std::vector<Voxel> walls;
  for (const auto& [v, odds] : voxels_of(map)) {
    if (odds > 0.0f) walls.push_back(v);
  }
  const std::size_t occupied = walls.size();
  ASSERT_GT(occupied, 1000U);
  Voxel low = walls.front();
  Voxel high = walls.front();
  for (const Voxel& v : walls) {
    low = {std::min(low.x, v.x - kReach), std::min(low.y, v.y - kReach), std::min(low.z, v.z)};
    high = {std::max(high.x, v.x + kReach), std::max(high.y, v.y + kReach), std::max(high.z, v.z)};
  }
  Distances nearest(low, high);  // squared, within reach
  for (const Voxel& v : walls) {
    for (int y = -kReach; y <= kReach; ++y) {
      for (int x = -kReach; x <= kReach; ++x) {
        if (const int square = x * x + y * y; square <= kReach * kReach) nearest.lower({v.x + x, v.y + y, v.z}, square);
      }
    }
  }
  std::size_t found = 0;
  map.for_all([&](TileIndex index, const TileColumn& column, bool) {
    column.for_all([&](std::int32_t tile_z, const VoxelTile& tile, bool) {
      for (int z = 0; z < VoxelOctree::kSide; ++z) {
        const Slab* slab = tile.slab(z);
        for (int i = 0; slab != nullptr && i < Slab::kSide * Slab::kSide; ++i) {
          const Voxel v{index.x * Slab::kSide + i % Slab::kSide, index.y * Slab::kSide + i / Slab::kSide,
                        tile_z * Slab::kSide + z};
          const int stored = slab->distance[static_cast<std::size_t>(i)];
          const int square = nearest.at(v);
          ASSERT_EQ(slab->is_occupied(v.x, v.y), square == 0);
          if (square == Distances::kNone) {
            ASSERT_EQ(stored, StoredDistance::kFar);
          } else {
            ++found;
            ASSERT_EQ(stored, std::lround(StoredDistance::kSteps * std::sqrt(square)));
          }
        }
      }
    });
  });
  EXPECT_EQ(found, nearest.size());
}

TEST(CloudInsertion, DistancesAreThoseOfADistanceTransformOfEveryLayer) {
  const OctomapGridSettings s = settings();
  std::mt19937 random(4);
  std::normal_distribution<double> error(0.0, 1.0);
  VoxelMap map;
  CloudInsertion insertion;
  for (int i = 0; i < 16; ++i) {
    const Pose& T_map_base = kPoses[static_cast<std::size_t>(i) % kPoses.size()];
    Pose wrong = T_map_base;
    wrong.p += 0.1 * Eigen::Vector3d(error(random), error(random), error(random));
    insertion.insert(map, wrong, observed(Hall(), T_map_base, tilted(), s, 0.03, static_cast<std::uint32_t>(i)), s);
    if (i % 8 == 7) expect_exact_distances(map);
  }
}

TEST(CloudInsertion, WhatChangesNothingStaysShared) {
  const OctomapGridSettings s = settings();
  VoxelMap map;
  CloudInsertion insertion;
  const CloudObservation seen = observed(Hall(), kPoses[0], tilted(), s);
  for (int i = 0; i < 20; ++i) insertion.insert(map, kPoses[0], seen, s);
  VoxelMap copy = map;
  insertion.insert(copy, kPoses[0], seen, s);
  EXPECT_TRUE(copy.shares_root_with(map));
  // Elsewhere it writes some tiles of its own, and none of the other map's.
  const std::map<Voxel, float> before = voxels_of(map);
  insertion.insert(copy, kPoses[2], observed(Hall(), kPoses[2], tilted(), s), s);
  EXPECT_EQ(voxels_of(map), before);
  EXPECT_NE(voxels_of(copy), before);
  const std::array<const VoxelMap*, 2> both{&map, &copy};
  const std::span<const VoxelMap* const> each(both);
  EXPECT_LT(VoxelMap::bytes_of(both), VoxelMap::bytes_of(each.first(1)) + VoxelMap::bytes_of(each.last(1)));
}

TEST(CloudInsertion, RefusesAPlaceBeyondTheMap) {
  const OctomapGridSettings s = settings();
  VoxelMap map;
  const CloudObservation seen = observed(Hall(), kPoses[0], tilted(), s);
  for (const Eigen::Vector3d& p : {Eigen::Vector3d(1e12, 0, 0), Eigen::Vector3d(0, 0, -1e12)}) {
    EXPECT_THROW(CloudInsertion().insert(map, Pose{Eigen::Quaterniond::Identity(), p}, seen, s), Error);
  }
}

}  // namespace
}  // namespace waymark::octomap_grid_test
