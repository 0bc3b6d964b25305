// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/maps/conversion.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <string>

#include "apps/waymark/maps/octree_file.hpp"
#include "waymark/base/error.hpp"

namespace waymark::maps {
namespace {

using ::testing::HasSubstr;

constexpr double kSide = 0.2;  // of a cell [m]

/// Free up to 1.6 m high, a table at 0.8 m over a part of it, and one unknown column.
octomap::OcTree table() {
  octomap::OcTree tree(kSide);
  for (int x = 0; x < 16; ++x) {
    for (int y = -8; y < 8; ++y) {
      for (int z = 0; z < 8; ++z) {
        if (x == 3 && y == 3) continue;
        tree.updateNode((x + 0.5) * kSide, (y + 0.5) * kSide, (z + 0.5) * kSide, z == 4 && x < 5 && y < 0);
      }
    }
  }
  tree.toMaxLikelihood();
  tree.prune();
  return tree;
}

int percent_at(const GridView& grid, double x, double y) {
  const Eigen::Vector3d cell = (grid.T_map_grid.inverse() * Eigen::Vector3d(x, y, 0.0)) / grid.resolution_m;
  return grid.cells[static_cast<std::size_t>(static_cast<int>(cell.y()) * grid.width + static_cast<int>(cell.x()))];
}

std::string message(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "none";
}

TEST(MapConversion, AFewNodesAreNoLargePicture) {
  octomap::OcTree tree(0.01);
  tree.updateNode(-300.0, -300.0, 0.5, true);
  tree.updateNode(20.0, 20.0, 0.5, true);
  EXPECT_THAT(message([&] { slice_of(tree, {0.0, 1.0}); }), HasSubstr("cells are too many for an octree of"));
}

TEST(MapConversion, ASliceIsWhatStandsBetweenItsHeights) {
  const octomap::OcTree tree = table();
  const GridView whole = slice_of(tree, {0.0, 1.6});
  EXPECT_EQ(whole.width, 16);
  EXPECT_EQ(whole.height, 16);
  EXPECT_NEAR(whole.T_map_grid.p.x(), 0.0, 1e-12);
  EXPECT_NEAR(whole.T_map_grid.p.y(), -1.6, 1e-12);
  EXPECT_EQ(percent_at(whole, 0.5, -0.5), 100);
  EXPECT_EQ(percent_at(whole, 0.5, 0.5), 0);
  EXPECT_EQ(percent_at(whole, 0.7, 0.7), GridView::kUnknown);
  EXPECT_EQ(std::ranges::count(whole.cells, 100), 5 * 8);
  // Layers have their middles at 0.1, 0.3, …; the table's is at 0.9 m.
  EXPECT_EQ(std::ranges::count(slice_of(tree, {0.0, 0.9}).cells, 100), 0);
  EXPECT_EQ(std::ranges::count(slice_of(tree, {0.9, 0.95}).cells, 100), 5 * 8);
  EXPECT_EQ(std::ranges::count(slice_of(tree, {0.95, 9.0}).cells, 100), 0);
}

TEST(MapConversion, ASliceWithoutVoxelsIsAnError) {
  const octomap::OcTree tree = table();
  EXPECT_THAT(message([&] { slice_of(tree, {0.11, 0.2}); }), HasSubstr("no voxel has its middle there"));
  EXPECT_THAT(message([&] { slice_of(tree, {1.0, 0.5}); }), HasSubstr("no voxel has its middle there"));
  EXPECT_THAT(message([&] { slice_of(tree, {3.0, 4.0}); }), HasSubstr("nothing is known"));
}

TEST(MapConversion, AGridIsALayerAndComesBack) {
  GridView grid;
  grid.resolution_m = kSide;
  grid.width = 7;
  grid.height = 4;
  grid.T_map_grid = Pose::planar(-0.6, 1.0, 0.0);
  grid.cells = {0,   0, 0, 0, 0, 0,   100,  //
                100, 0, 0, 0, 0, 255, 0,    //
                0,   0, 0, 0, 0, 255, 0,    //
                0,   0, 0, 0, 0, 0,   0};
  const auto tree = layer_of(grid);
  const OctreeFigures figures = figures_of(*tree);
  EXPECT_EQ(figures.occupied, 2u);
  EXPECT_EQ(figures.free, 24u);
  EXPECT_NEAR(figures.low_m[2], 0.0, 1e-12);
  EXPECT_NEAR(figures.high_m[2], kSide, 1e-12);
  const GridView back = slice_of(*tree, {0.0, kSide});
  EXPECT_EQ(back.cells, grid.cells);
  EXPECT_EQ(back.width, grid.width);
  EXPECT_NEAR((back.T_map_grid.p - grid.T_map_grid.p).norm(), 0.0, 1e-12);
}

TEST(MapConversion, AGridThatNoOctreeCanHoldIsAnError) {
  GridView grid;
  grid.resolution_m = kSide;
  grid.width = grid.height = 1;
  grid.cells = {100};
  grid.T_map_grid = Pose::planar(0.0, 0.0, 0.3);
  EXPECT_THAT(message([&] { layer_of(grid); }), HasSubstr("the yaw, is 0.3"));
  grid.T_map_grid = Pose::planar(32767 * kSide, 0.0, 0.0);
  EXPECT_EQ(message([&] { layer_of(grid); }), "none");
  grid.T_map_grid = Pose::planar(32768 * kSide, 0.0, 0.0);
  EXPECT_THAT(message([&] { layer_of(grid); }), HasSubstr("32768 cells from the map's origin"));
}

}  // namespace
}  // namespace waymark::maps
