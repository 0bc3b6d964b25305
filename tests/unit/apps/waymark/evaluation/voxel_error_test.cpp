// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/evaluation/voxel_error.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "apps/waymark/maps/octree_file.hpp"
#include "temporary_folder.hpp"
#include "waymark/base/error.hpp"

namespace waymark::evaluation {
namespace {

constexpr double kSide = 0.1;  // of a voxel [m]

/// A wall from (0.05, 0) to (0.05, 2), 1 m high: it runs through the middles of 20 × 10 voxels.
const std::vector<Surface> kWall{{Surface::Kind::box, {0.05, 0.0}, {0.05, 2.0}, 0.0, 1.0}};

class VoxelScore : public ::testing::Test {
 protected:
  void set(int x, int y, int z, bool occupied) {
    const octomap::point3d p(static_cast<float>((x + 0.5) * kSide), static_cast<float>((y + 0.5) * kSide),
                             static_cast<float>((z + 0.5) * kSide));
    tree_.setNodeValue(p, occupied ? 2.0f : -2.0f);
  }
  /// The wall's voxels, `offset` voxels off.
  void set_wall(int offset, bool occupied = true, int y_end = 20) {
    for (int y = 0; y < y_end; ++y) {
      for (int z = 0; z < 10; ++z) set(offset, y, z, occupied);
    }
  }
  VoxelError score(double tolerance_m = 0.0) {
    std::ofstream(file_, std::ios::binary) << map_formats::octree_text(tree_, map_formats::OctreeFormat::binary);
    return score_voxels(file_, kWall, {.tolerance_m = tolerance_m});
  }

  octomap::OcTree tree_{kSide};
  test::TemporaryFolder folder_;
  std::filesystem::path file_ = folder_ / "voxels.bt";
};

TEST_F(VoxelScore, AMapOfTheTruthIsRight) {
  set_wall(0);
  const VoxelError error = score();
  EXPECT_EQ(error.occupied, 200u);
  EXPECT_EQ(error.precision(), 1.0);
  EXPECT_EQ(error.points, 200u);
  EXPECT_EQ(error.recall(), 1.0);
  EXPECT_NEAR(error.distance_m.max, 0.0, 1e-12);
  EXPECT_EQ(error.tolerance_m, kSide);
}

TEST_F(VoxelScore, AWallFurtherOffThanTheToleranceIsWrongAndMissing) {
  set_wall(3);
  set_wall(0, false);
  VoxelError error = score(0.15);
  EXPECT_EQ(error.precision(), 0.0);
  EXPECT_EQ(error.recall(), 0.0);
  EXPECT_NEAR(error.distance_m.mean, 0.3, 1e-9);
  error = score(0.31);
  EXPECT_EQ(error.precision(), 1.0);
  EXPECT_EQ(error.recall(), 1.0);
}

TEST_F(VoxelScore, HalfWrongIsHalf) {
  set_wall(0);
  set_wall(5);
  EXPECT_EQ(score().precision(), 0.5);
  EXPECT_EQ(score().recall(), 1.0);
}

TEST_F(VoxelScore, WhatWasNotSeenIsNotMissed) {
  // Half of the wall is mapped, a quarter is called free, the rest is unknown within the map's corners.
  set_wall(0, true, 10);
  for (int y = 10; y < 15; ++y) {
    for (int z = 0; z < 10; ++z) set(0, y, z, false);
  }
  set(0, 19, 0, true);
  const VoxelError error = score(0.01);
  EXPECT_EQ(error.points, 200u);
  EXPECT_EQ(error.found, 101u);
  EXPECT_EQ(error.missed, 50u);
  EXPECT_NEAR(error.recall(), 101.0 / 151.0, 1e-12);
}

TEST_F(VoxelScore, CountsTheVoxelsOfLargeLeaves) {
  for (int x = 8; x < 16; ++x) {
    for (int y = 0; y < 8; ++y) {
      for (int z = 0; z < 8; ++z) set(x, y, z, true);
    }
  }
  EXPECT_EQ(score().occupied, 512u);
  EXPECT_EQ(score().right, 0u);
  EXPECT_EQ(score(0.85).right, 64u);  // the layer at x = 0.85, 0.8 m from the wall
}

TEST_F(VoxelScore, RefusesWhatCannotBeScored) {
  set_wall(0, false);
  EXPECT_THROW(score(), DataError);
  set_wall(0);
  EXPECT_THROW(score(1.1), Error);
}

}  // namespace
}  // namespace waymark::evaluation
