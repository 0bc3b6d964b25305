// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/maps/octree_file.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "plugins/shared/map_formats/octree_bytes.hpp"
#include "temporary_folder.hpp"
#include "waymark/base/error.hpp"
#include "waymark/math/random.hpp"

namespace waymark::maps {
namespace {

using map_formats::OctreeFormat;

using ::testing::HasSubstr;

constexpr double kSide = 0.1;  // of a voxel [m]

/// 9 × 8 × 5 voxels around the origin: a floor, a wall, free space, a gap; where all eight agree, it is pruned.
std::unique_ptr<octomap::OcTree> small_room() {
  auto tree = std::make_unique<octomap::OcTree>(kSide);
  for (int x = -4; x < 5; ++x) {
    for (int y = -4; y < 4; ++y) {
      for (int z = -1; z < 4; ++z) {
        if (x == 2 && y > 1) continue;  // unknown
        const bool occupied = z == -1 || x == 4;
        tree->updateNode((x + 0.5) * kSide, (y + 0.5) * kSide, (z + 0.5) * kSide, occupied);
      }
    }
  }
  return tree;
}

class OctreeFile : public ::testing::Test {
 protected:
  LoadedOctree read(const std::string& content) const {
    std::ofstream(file_, std::ios::binary) << content;
    return read_octree(file_);
  }
  std::string message(const std::string& content) const {
    try {
      read(content);
    } catch (const DataError& error) {
      EXPECT_THAT(error.what(), HasSubstr(file_.string()));
      return error.what();
    }
    return "none";
  }

  test::TemporaryFolder folder_;
  std::filesystem::path file_ = folder_ / "map.bt";
};

std::string with(std::string text, const std::string& what, const std::string& instead) {
  return text.replace(text.find(what), what.size(), instead);
}

TEST_F(OctreeFile, EveryVoxelComesBackFromBothFormats) {
  for (const OctreeFormat format : {OctreeFormat::full, OctreeFormat::binary}) {
    const auto written = small_room();
    const auto original = small_room();
    const LoadedOctree loaded = read(octree_text(*written, format));
    EXPECT_EQ(loaded.format, format);
    EXPECT_EQ(loaded.tree->getResolution(), kSide);
    for (int x = -6; x < 7; ++x) {
      for (int y = -6; y < 6; ++y) {
        for (int z = -3; z < 6; ++z) {
          const octomap::point3d p(static_cast<float>((x + 0.5) * kSide), static_cast<float>((y + 0.5) * kSide),
                                   static_cast<float>((z + 0.5) * kSide));
          const octomap::OcTreeNode* before = original->search(p);
          const octomap::OcTreeNode* after = loaded.tree->search(p);
          ASSERT_EQ(before == nullptr, after == nullptr);
          if (before == nullptr) continue;
          ASSERT_EQ(original->isNodeOccupied(before), loaded.tree->isNodeOccupied(after));
          if (format == OctreeFormat::full) {
            ASSERT_EQ(before->getLogOdds(), after->getLogOdds());
          }
        }
      }
    }
  }
}

TEST_F(OctreeFile, FiguresCountVoxelsWhateverTheLeaves) {
  const auto tree = small_room();
  for (int pruned = 0; pruned < 2; ++pruned) {
    const OctreeFigures figures = figures_of(*tree);
    EXPECT_EQ(figures.occupied, 9u * 8u - 2u + 8u * 4u);
    EXPECT_EQ(figures.unknown, 2u * 5u);
    EXPECT_EQ(figures.occupied + figures.free + figures.unknown, 9u * 8u * 5u);
    EXPECT_NEAR(figures.low_m[0], -0.4, 1e-12);
    EXPECT_NEAR(figures.high_m[0], 0.5, 1e-12);
    EXPECT_NEAR(figures.low_m[2], -0.1, 1e-12);
    EXPECT_NEAR(figures.high_m[2], 0.4, 1e-12);
    tree->toMaxLikelihood();
    tree->prune();
  }
}

TEST_F(OctreeFile, AnEmptyTreeIsATree) {
  octomap::OcTree nothing(0.25);
  const LoadedOctree loaded = read(octree_text(nothing, OctreeFormat::binary));
  EXPECT_EQ(loaded.tree->getResolution(), 0.25);
  EXPECT_EQ(figures_of(*loaded.tree).leaves, 0u);
}

TEST_F(OctreeFile, TheResolutionKeepsAllItsDigits) {
  octomap::OcTree fine(0.123456789);
  EXPECT_EQ(read(octree_text(fine, OctreeFormat::full)).tree->getResolution(), 0.123456789);
}

TEST_F(OctreeFile, NoBeginningOfAFileIsTakenForTheWhole) {
  for (const OctreeFormat format : {OctreeFormat::full, OctreeFormat::binary}) {
    const std::string text = octree_text(*small_room(), format);
    for (std::size_t length = 0; length < text.size(); ++length)
      ASSERT_THROW(map_formats::OctreeBytes(text.substr(0, length), "cut.bt").check(), DataError)
          << length << " of " << text.size();
    EXPECT_THAT(message(text.substr(0, text.size() - 1)), HasSubstr("truncated"));
    EXPECT_THAT(message(text + "x"), HasSubstr("1 bytes follow the last node"));
  }
}

TEST_F(OctreeFile, WrongBytesAreRefusedOrReadButNeverTrusted) {
  Random random({.seed = 5, .slot = 0, .stamp = 0, .sensor = 0});
  int refused = 0;
  for (const OctreeFormat format : {OctreeFormat::full, OctreeFormat::binary}) {
    const std::string text = octree_text(*small_room(), format);
    for (int i = 0; i < 300; ++i) {
      std::string spoilt = text;
      for (int flips = 0; flips < 3; ++flips) {
        const auto at = static_cast<std::size_t>(random.uniform() * static_cast<double>(spoilt.size() - 1));
        spoilt[at] = static_cast<char>(static_cast<int>(256.0 * random.uniform()));
      }
      try {
        figures_of(*read(spoilt).tree);
      } catch (const DataError&) {
        ++refused;
      }
    }
  }
  EXPECT_GT(refused, 150);
}

TEST_F(OctreeFile, TellsWhatIsWrong) {
  const std::string text = octree_text(*small_room(), OctreeFormat::binary);
  EXPECT_THAT(message("P5\n4 3\n255\n"), HasSubstr("the first line must be \"# Octomap OcTree binary file\""));
  EXPECT_THAT(message(with(text, "id OcTree", "id ColorOcTree")), HasSubstr("id is ColorOcTree"));
  EXPECT_THAT(message(with(text, "res 0.1", "res -0.1")), HasSubstr("res is -0.1 m; more than 0"));
  EXPECT_THAT(message(with(text, "res 0.1", "res wide")), HasSubstr("res is \"wide\"; a number was expected"));
  EXPECT_THAT(message(with(text, "res 0.1\n", "")), HasSubstr("id, size and res are expected"));
  EXPECT_THAT(message(with(text, "size ", "size 9")), HasSubstr("are there"));
  EXPECT_THAT(message(with(text, "data\n", "date\n")), HasSubstr("header"));
  EXPECT_THAT(message(with(text, "size", "colour red\nsize")), HasSubstr("\"colour red\" is not expected"));
  std::filesystem::remove(file_);
  EXPECT_THROW(read_octree(file_), DataError);
  EXPECT_THROW(read_octree(folder_), DataError);
}

TEST_F(OctreeFile, NoNodeLiesBelowTheLastLevel) {
  // Inner nodes only, each with one child that has children again.
  const std::string header = "# Octomap OcTree binary file\nid OcTree\nsize 100000\nres 0.1\ndata\n";
  std::string deep = header;
  for (int i = 0; i < 100000; ++i) deep += std::string("\x03\x00", 2);
  EXPECT_THAT(message(deep), HasSubstr("below the 16 levels"));
  std::string sixteen = with(header, "100000", "17");
  for (int i = 0; i < 15; ++i) sixteen += std::string("\x03\x00", 2);
  const LoadedOctree loaded = read(sixteen + std::string("\x02\x00", 2));
  EXPECT_EQ(figures_of(*loaded.tree).occupied, 1u);
}

}  // namespace
}  // namespace waymark::maps
