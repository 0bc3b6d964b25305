// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/maps/map_edits.hpp"

#include <gmock/gmock.h>

#include <functional>
#include <numbers>
#include <string>

#include "apps/waymark/maps/octree_edits.hpp"
#include "waymark/base/error.hpp"

namespace waymark::maps {
namespace {

using ::testing::HasSubstr;

constexpr double kSide = 0.5;  // of a voxel and of a cell [m]

std::string error_of(const std::function<void()>& what) {
  try {
    what();
  } catch (const Error& error) {
    return error.what();
  }
  ADD_FAILURE() << "no error";
  return "";
}

/// A block of 8 × 8 × 4 voxels from the origin on, in large leaves, half of it occupied.
LoadedOctree block() {
  auto tree = std::make_unique<octomap::OcTree>(kSide);
  for (int x = 0; x < 8; ++x) {
    for (int y = 0; y < 8; ++y) {
      for (int z = 0; z < 4; ++z)
        tree->setNodeValue((x + 0.5) * kSide, (y + 0.5) * kSide, (z + 0.5) * kSide, x < 4 ? 1.0F : -1.0F);
    }
  }
  tree->prune();
  return {std::move(tree), map_formats::OctreeFormat::full};
}

std::uint64_t voxels_of(const LoadedOctree& octree) {
  const OctreeFigures figures = figures_of(*octree.tree);
  return figures.occupied + figures.free;
}

LayeredMap map_of(std::vector<std::string> names) {
  LayeredMap map;
  map.is_manifest = true;
  map.datum = Datum{48.0, 11.0, 500.0};
  for (const std::string& name : names) {
    Layer layer{name, {}, {}};
    if (name == "tree") {
      layer.content = block();
    } else if (name == "grid") {
      layer.content = GridView{Pose::planar(0.0, 0.0, 0.0), kSide, 4, 2, {0, 100, 255, 0, 100, 0, 0, 255}};
    } else {
      Landmarks two(2);
      two[0].mean = {1.0, 1.0, 0.2};
      two[1].mean = {3.0, 1.0, 0.2};
      for (auto& one : two) one.P = 0.01 * Eigen::Matrix3d::Identity();
      layer.content = two;
    }
    map.layers.push_back(std::move(layer));
  }
  return map;
}

const Landmarks& landmarks_of(const LayeredMap& map) { return std::get<Landmarks>(map.layers.front().content); }
const GridView& grid_of(const LayeredMap& map) { return std::get<GridView>(map.layers.front().content); }
const LoadedOctree& tree_of(const LayeredMap& map) { return std::get<LoadedOctree>(map.layers.front().content); }

TEST(MapCrop, LeavesWhatHasItsMiddleInTheBox) {
  LayeredMap map = map_of({"tree", "grid", "landmarks"});
  crop(map, {0.0, 0.0, 2.0, 1.0, -1.0, 1.0});
  ASSERT_EQ(map.layers.size(), 3u);
  EXPECT_EQ(voxels_of(tree_of(map)), 4u * 2u * 2u);
  EXPECT_EQ(std::get<Landmarks>(map.layers[2].content).size(), 1u);
  LayeredMap grid = map_of({"grid"});
  crop(grid, {0.5, -10.0, 1.5, 0.5});
  EXPECT_EQ(grid_of(grid).width, 1) << "the unknown cell is not kept";
  EXPECT_NEAR(grid_of(grid).T_map_grid.p.x(), 0.5, 1e-12);
  EXPECT_EQ(grid_of(grid).cells, std::vector<std::uint8_t>{100});
}

TEST(MapCrop, OfATurnedOctreeIsInTheFrameOfTheMap) {
  LayeredMap map = map_of({"tree"});
  map.layers.front().T_frame_file = Pose::planar(10.0, 0.0, 0.5 * std::numbers::pi);  // it lies from x 6 to 10
  crop(map, {8.0, -1.0, 11.0, 1.0});
  EXPECT_EQ(voxels_of(tree_of(map)), 4u * 2u * 4u);
  EXPECT_EQ(figures_of(*tree_of(map).tree).occupied, 4u * 2u * 4u) << "its x became y";
}

TEST(MapCrop, TakesEmptyLayersOutAndRefusesToLeaveNothing) {
  LayeredMap map = map_of({"tree", "landmarks"});
  crop(map, {2.9, 0.9, 3.1, 1.1});
  ASSERT_EQ(map.layers.size(), 1u) << "no middle of a voxel lies there";
  EXPECT_THAT(error_of([&] { crop(map, {50.0, 50.0, 60.0, 60.0}); }), HasSubstr("nothing of the map lies between"));
}

TEST(MapMerge, OfTwoHalvesIsTheWhole) {
  const LayeredMap whole = map_of({"tree"});
  LayeredMap west = map_of({"tree"});
  LayeredMap east = map_of({"tree"});
  crop(west, {-1.0, -1.0, 1.5, 9.0});
  crop(east, {1.5, -1.0, 9.0, 9.0});
  merge(west, east, 0.5);
  EXPECT_EQ(voxels_of(tree_of(west)), voxels_of(tree_of(whole)));
  EXPECT_EQ(figures_of(*tree_of(west).tree).occupied, figures_of(*tree_of(whole).tree).occupied);
}

TEST(MapMerge, AddsLogOddsOfVoxelsWhereTheyLie) {
  LayeredMap map = map_of({"tree"});
  LayeredMap other = map_of({"tree"});
  other.layers.front().T_frame_file = Pose::planar(2.0, 0.0, 0.0);  // its occupied half on the free one
  merge(map, other, 0.5);
  const octomap::OcTree& tree = *tree_of(map).tree;
  EXPECT_NEAR(tree.search(0.25, 0.25, 0.25)->getLogOdds(), 1.0, 1e-6);
  EXPECT_NEAR(tree.search(2.25, 0.25, 0.25)->getLogOdds(), 0.0, 1e-6);
  EXPECT_NEAR(tree.search(4.25, 0.25, 0.25)->getLogOdds(), -1.0, 1e-6);
}

TEST(MapMerge, KeepsTheBetterOfTwoLandmarksAndTheOccupiedOfTwoCells) {
  LayeredMap map = map_of({"landmarks"});
  LayeredMap other = map_of({"landmarks"});
  Landmarks moved = landmarks_of(other);
  moved[0].mean.x() = 1.3;
  moved[0].P *= 0.1;
  moved[1].mean.x() = 4.0;
  other.layers.front().content = moved;
  merge(map, other, 0.5);
  ASSERT_EQ(landmarks_of(map).size(), 3u);
  EXPECT_EQ(landmarks_of(map)[0].mean.x(), 1.3);

  LayeredMap grid = map_of({"grid"});
  LayeredMap shifted = map_of({"grid"});
  move(shifted, Pose::planar(kSide, 0.0, 0.0));
  merge(grid, shifted, 0.5);
  EXPECT_EQ(grid_of(grid).width, 5);
  EXPECT_EQ(grid_of(grid).cells, (std::vector<std::uint8_t>{0, 100, 100, 0, 0, 100, 100, 0, 0, 255}));
}

TEST(MapMerge, RefusesOtherFramesFormatsAndResolutions) {
  LayeredMap map = map_of({"tree"});
  LayeredMap other = map_of({"tree"});
  other.datum->longitude_deg = 11.5;
  EXPECT_THAT(error_of([&] { merge(map, other, 0.5); }),
              HasSubstr("datum 48, 11, 500 m and datum 48, 11.5, 500 m: maps in one frame are expected"));
  other.datum.reset();
  map.datum.reset();
  EXPECT_THAT(error_of([&] { merge(map, other, 0.5); }), HasSubstr("datum none and datum none"));
  other = map_of({"grid"});
  map = map_of({"tree"});
  other.layers.front().name = "tree";
  EXPECT_THAT(error_of([&] { merge(map, other, 0.5); }), HasSubstr("are of different formats"));
  octomap::OcTree fine(0.25);
  EXPECT_THAT(error_of([&] { merge_octrees(*tree_of(map).tree, fine, {}); }),
              HasSubstr("voxels of 0.5 m and of 0.25 m"));
}

TEST(MapMove, BetweenDatumsAndBackIsNoMove) {
  const Datum here{48.0, 11.0, 500.0};
  const Datum there{48.01, 11.02, 510.0};
  const Pose away = between(there, here);
  EXPECT_NEAR(away.p.x(), -1491.0, 5.0);  // 0.02° of longitude at 48°
  EXPECT_NEAR(away.p.y(), -1112.0, 5.0);
  const Pose back = between(here, there) * away;
  EXPECT_LT(back.p.head<2>().norm(), 0.01) << "of 2 km";
  EXPECT_LT(std::abs(back.yaw()), 1e-6);
  EXPECT_THAT(error_of([&] { between(here, {49.0, 11.0, 500.0}); }), HasSubstr("at most 10000 m are possible"));
}

}  // namespace
}  // namespace waymark::maps
