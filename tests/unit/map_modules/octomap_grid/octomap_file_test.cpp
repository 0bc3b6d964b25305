// SPDX-License-Identifier: Apache-2.0
#include "map_modules/octomap_grid/octomap_file.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "map_modules/octomap_grid/map_view.hpp"
#include "temporary_folder.hpp"
#include "tests/unit/map_modules/octomap_grid/simulated_hall.hpp"
#include "waymark/base/error.hpp"

namespace waymark::octomap_grid_test {
namespace {

using ::testing::HasSubstr;

const Pose kPose{so3::from_rpy(0.02, -0.03, 0.3), {-0.4, 0.2, 0.1}};

class OctomapFile : public ::testing::Test {
 protected:
  OctomapFile() {
    CloudInsertion insertion;
    for (int i = 0; i < 3; ++i) insertion.insert(map_, kPose, observed(Hall(), kPose, tilted(), settings_), settings_);
    files_ = octomap_files(map_, settings_.resolution);
  }

  std::filesystem::path write(const std::string& content, const char* name = "map") const {
    std::ofstream(folder_ / name, std::ios::binary) << content;
    return folder_ / name;
  }
  std::string message(const std::string& content) const {
    try {
      load_octomap(write(content), settings_);
    } catch (const Error& error) {
      return error.what();
    }
    return "none";
  }
  static std::string with(std::string text, const std::string& from, const std::string& to) {
    return text.replace(text.find(from), from.size(), to);
  }

  test::TemporaryFolder folder_;
  OctomapGridSettings settings_ = settings();
  VoxelMap map_;
  std::vector<MapFile> files_;
};

TEST_F(OctomapFile, IsReadByOctoMap) {
  ASSERT_EQ(files_.size(), 2U);
  EXPECT_EQ(files_[0].extension, ".bt");
  EXPECT_EQ(files_[1].extension, ".ot");
  std::istringstream binary(files_[0].content);
  octomap::OcTree occupied(0.1);
  ASSERT_TRUE(occupied.readBinary(binary));
  std::istringstream full(files_[1].content);
  const std::unique_ptr<octomap::AbstractOcTree> read(octomap::AbstractOcTree::read(full));
  const auto* tree = dynamic_cast<const octomap::OcTree*>(read.get());
  ASSERT_NE(tree, nullptr);
  EXPECT_DOUBLE_EQ(tree->getResolution(), 0.1);
  std::size_t known = 0;
  for_all_leaves(map_, [&](Voxel v, int side, float odds) {
    const float half = 0.5f * static_cast<float>(side);
    const auto middle = [&](std::int32_t i) { return 0.1f * (static_cast<float>(i) + half); };
    const octomap::OcTreeNode* node = tree->search(middle(v.x), middle(v.y), middle(v.z));
    ASSERT_NE(node, nullptr);
    ASSERT_FLOAT_EQ(node->getLogOdds(), odds);
    const octomap::OcTreeNode* either = occupied.search(middle(v.x), middle(v.y), middle(v.z));
    ASSERT_NE(either, nullptr);
    ASSERT_EQ(either->getLogOdds() > 0.0f, odds > 0.0f);
    ++known;
  });
  EXPECT_GT(known, 5000U);
}

TEST_F(OctomapFile, ComesBackAsItWas) {
  const MapFigures before = figures_of(map_);
  for (const MapFile& file : files_) {
    const VoxelMap again = load_octomap(write(file.content), settings_);
    const MapFigures after = figures_of(again);
    EXPECT_EQ(after.occupied, before.occupied) << file.extension;
    EXPECT_EQ(after.free, before.free) << file.extension;
    const bool is_full = file.extension == ".ot";
    for_all_leaves(map_, [&](Voxel v, int, float odds) {
      const VoxelTile* tile = again.read({tile_of(v.x), tile_of(v.y)}).find(tile_of(v.z));
      ASSERT_NE(tile, nullptr);
      const auto local = [](std::int32_t i) { return static_cast<std::uint8_t>(i & (VoxelOctree::kSide - 1)); };
      const float* found = tile->voxels.find({local(v.x), local(v.y), local(v.z)});
      ASSERT_NE(found, nullptr);
      EXPECT_FLOAT_EQ(*found, is_full ? odds : (odds > 0.0f ? 1.75f : -1.0f));
    });
    // The distances are there, too: those that insertion made.
    map_.for_all([&](TileIndex index, const TileColumn& column, bool) {
      column.for_all([&](std::int32_t z, const VoxelTile& tile, bool) {
        const VoxelTile* there = again.read(index).find(z);
        for (int layer = 0; layer < VoxelOctree::kSide; ++layer) {
          const Slab* slab = tile.slab(layer);
          if (slab == nullptr || *std::ranges::min_element(slab->distance) == scan_matching::StoredDistance::kFar)
            continue;
          ASSERT_NE(there, nullptr);
          ASSERT_NE(there->slab(layer), nullptr);
          EXPECT_EQ(there->slab(layer)->distance, slab->distance);
        }
      });
    });
  }
}

TEST_F(OctomapFile, WhatIsAsLikelyFreeAsOccupiedIsFreeForOctoMapToo) {
  VoxelOctree::Draft draft;
  draft.set({1, 2, 3}, 0, 0.0f);
  draft.set({4, 5, 6}, 0, 0.05f);
  VoxelMap map;
  map.write({0, 0}).write(0).voxels = VoxelOctree(draft);
  for (const MapFile& file : octomap_files(map, settings_.resolution)) {
    const MapFigures after = figures_of(load_octomap(write(file.content), settings_));
    EXPECT_EQ(after.occupied, 1U) << file.extension;
    EXPECT_EQ(after.free, 1U) << file.extension;
  }
}

TEST_F(OctomapFile, TellsWhatIsWrong) {
  const std::string& bt = files_[0].content;
  const std::string& ot = files_[1].content;
  EXPECT_EQ(message(bt), "none");
  EXPECT_EQ(message(ot), "none");
  EXPECT_THAT(message("P5\n4 3\n255\n"), HasSubstr("map: not an octree of OctoMap: the first line must be"));
  EXPECT_THAT(message(""), HasSubstr("not an octree"));
  EXPECT_THAT(message(bt.substr(0, 60)), HasSubstr("the line \"data\" is missing"));
  EXPECT_THAT(message(bt.substr(0, bt.size() - 7)), HasSubstr("truncated"));
  EXPECT_THAT(message(bt + "x"), HasSubstr("1 bytes follow the last node"));
  EXPECT_THAT(message(ot.substr(0, ot.size() - 7)), HasSubstr("truncated"));
  EXPECT_THAT(message(ot + "x"), HasSubstr("1 bytes follow the last node"));
  EXPECT_THAT(message(with(bt, "id OcTree", "id ColorOcTree")),
              HasSubstr("id is ColorOcTree; only trees of the id OcTree are read"));
  EXPECT_THAT(message(with(bt, "res 0.1", "res 0.2")), HasSubstr("its voxels have 0.2 m, but resolution_m is 0.1"));
  EXPECT_THAT(message(with(bt, "res 0.1", "res wide")), HasSubstr("res is \"wide\""));
  EXPECT_THAT(message(with(bt, "size ", "size 99")), HasSubstr("are there"));
  EXPECT_THAT(message(with(bt, "size ", "size 99999999")), HasSubstr("a map has at most"));
  EXPECT_THAT(message(with(bt, "size ", "size -")), HasSubstr("a number was expected"));
  EXPECT_THROW(load_octomap(folder_ / "none.bt", settings_), DataError);

  // Odds that are no number, and a file of inner nodes only, deeper than an octree is.
  const std::string head = "# Octomap OcTree file\nid OcTree\nsize 1\nres 0.1\ndata\n";
  EXPECT_THAT(message(head + std::string("\x00\x00\xc0\x7f\x00", 5)), HasSubstr("log-odds are nan"));
  EXPECT_EQ(message(head + std::string("\x00\x00\x00\x40\x00", 5)).find("none"), std::string::npos);
  const std::string deep = "# Octomap OcTree binary file\nid OcTree\nsize 40\nres 0.1\ndata\n";
  EXPECT_THAT(message(deep + std::string(80, '\x03')), HasSubstr("below the 16 levels"));
  std::string chain = "# Octomap OcTree file\nid OcTree\nsize 40\nres 0.1\ndata\n";
  for (int i = 0; i < 40; ++i) chain += std::string("\0\0\x80\x3f\x01", 5);
  EXPECT_THAT(message(chain), HasSubstr("below the 16 levels"));
}

/// One leaf high up in the octree stands for more voxels than fit into memory.
TEST_F(OctomapFile, RefusesAMapThatIsTooLarge) {
  const std::string root_leaves = "# Octomap OcTree binary file\nid OcTree\nsize 9\nres 0.1\ndata\n";
  EXPECT_THAT(message(root_leaves + "\x55\x55"), HasSubstr("the map fills more than"));
}

/// A chain of so many inner nodes, each the first child of the one above, down to one occupied leaf: a solid cube of
/// 2^(16 - inner) voxels a side at the lowest corner of the octree.
std::string solid_cube(int inner) {
  std::string text = fmt::format("# Octomap OcTree file\nid OcTree\nsize {}\nres 0.1\ndata\n", inner + 1);
  const std::string odds("\0\0\x40\x40", 4);  // 3
  for (int i = 0; i < inner; ++i) text += odds + '\x01';
  return text + odds + '\0';
}

TEST_F(OctomapFile, RefusesAFewBytesThatClaimALot) {
  EXPECT_THAT(message(solid_cube(6)), HasSubstr("cubes of 4096 voxels, the most that a file of"));
  EXPECT_THAT(message(solid_cube(8)), HasSubstr("cubes of 4096 voxels, the most that a file of"));
  EXPECT_EQ(message(solid_cube(9)), "none");
}

TEST_F(OctomapFile, DistancesOfASolidCubeAreThoseToItsFaces) {
  constexpr std::int32_t kLow = -(1 << 15);
  constexpr std::int32_t kHigh = kLow + 31;
  const VoxelMap map = load_octomap(write(solid_cube(11)), settings_);
  std::size_t inside = 0;
  std::size_t within_reach = 0;
  map.for_all([&](TileIndex index, const TileColumn& column, bool) {
    column.for_all([&](std::int32_t, const VoxelTile& tile, bool) {
      for (int layer = 0; layer < VoxelOctree::kSide; ++layer) {
        const Slab* slab = tile.slab(layer);
        for (int i = 0; slab != nullptr && i < Slab::kSide * Slab::kSide; ++i) {
          const std::int32_t x = index.x * Slab::kSide + i % Slab::kSide;
          const std::int32_t y = index.y * Slab::kSide + i / Slab::kSide;
          const double apart = std::hypot(x - std::clamp(x, kLow, kHigh), y - std::clamp(y, kLow, kHigh));
          const bool is_near = apart <= scan_matching::StoredDistance::kReach;
          ASSERT_EQ(slab->distance[static_cast<std::size_t>(i)],
                    is_near ? std::lround(scan_matching::StoredDistance::kSteps * apart)
                            : scan_matching::StoredDistance::kFar);
          inside += apart == 0.0;
          within_reach += is_near && apart > 0.0;
        }
      }
    });
  });
  EXPECT_EQ(inside, 32U * 32U * 32U);
  // Beside each face 6 rows of 32, at each corner the voxels of a quarter of the disc.
  EXPECT_EQ(within_reach, 32U * 4U * (6U * 32U + 22U));
}

TEST(OctomapSample, OfFreiburgIsRead) {
  const char* data = std::getenv("WAYMARK_DATA");
  if (data == nullptr || *data == '\0') GTEST_SKIP() << "WAYMARK_DATA is not set";
  const std::filesystem::path file = std::filesystem::path(data) / "octomap_samples/geb079.bt";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not there";
  const VoxelMap map = load_octomap(file, settings("{ resolution_m: 0.08 }"));
  octomap::OcTree tree(0.08);
  ASSERT_TRUE(tree.readBinary(file.string()));
  std::size_t occupied = 0;
  std::size_t free = 0;
  for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf) {
    const auto side = static_cast<std::size_t>(std::lround(leaf.getSize() / 0.08));
    (tree.isNodeOccupied(*leaf) ? occupied : free) += side * side * side;
  }
  const MapFigures figures = figures_of(map);
  EXPECT_EQ(figures.occupied, occupied);
  EXPECT_EQ(figures.free, free);
  EXPECT_GT(occupied, 10'000U);
  // Out again and in again: the same.
  const std::vector<MapFile> files = octomap_files(map, 0.08);
  std::istringstream stream(files.front().content);
  octomap::OcTree again(0.08);
  ASSERT_TRUE(again.readBinary(stream));
  EXPECT_EQ(again.size(), tree.size());
}

}  // namespace
}  // namespace waymark::octomap_grid_test
