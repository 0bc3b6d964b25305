// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/maps/octree_picture.hpp"

#include <gmock/gmock.h>

#include <array>
#include <fstream>
#include <string>

#include "temporary_folder.hpp"
#include "waymark/base/error.hpp"

namespace waymark::maps {
namespace {

/// Two towers of voxels of 1 m, the one in the north twice as high, and a free voxel beside them.
octomap::OcTree towers() {
  octomap::OcTree tree(1.0);
  for (int z = 0; z < 4; ++z) tree.updateNode(octomap::point3d(0.5F, 10.5F, static_cast<float>(z) + 0.5F), true);
  for (int z = 0; z < 2; ++z) tree.updateNode(octomap::point3d(0.5F, 0.5F, static_cast<float>(z) + 0.5F), true);
  tree.updateNode(octomap::point3d(5.5F, 5.5F, 0.5F), false);
  tree.updateInnerOccupancy();
  return tree;
}

std::array<int, 3> pixel(const Picture& picture, int x, int y) {
  const std::size_t at = 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width) + x);
  return {picture.rgb[at], picture.rgb[at + 1], picture.rgb[at + 2]};
}

/// The lowest row that is not white in a part of the columns; 0 is the upper edge.
int top_row(const Picture& picture, double from, double to) {
  for (int y = 0; y < picture.height; ++y) {
    for (int x = static_cast<int>(from * picture.width); x < static_cast<int>(to * picture.width); ++x) {
      if (pixel(picture, x, y) != std::array{255, 255, 255}) return y;
    }
  }
  return picture.height;
}

TEST(OctreePicture, FromTheEastNorthIsRightAndHighIsUp) {
  const Picture picture = picture_of(towers(), {.from_deg = 0.0, .tilt_deg = 10.0, .width_px = 400}, {});
  EXPECT_EQ(picture.width, 400);
  EXPECT_EQ(picture.rgb.size(), 3U * 400U * static_cast<std::size_t>(picture.height));
  EXPECT_LT(top_row(picture, 0.5, 1.0), top_row(picture, 0.0, 0.5));
  const Picture from_west = picture_of(towers(), {.from_deg = 180.0, .tilt_deg = 10.0, .width_px = 400}, {});
  EXPECT_GT(top_row(from_west, 0.5, 1.0), top_row(from_west, 0.0, 0.5));
}

TEST(OctreePicture, HeightsLeaveOutACeiling) {
  const Picture all = picture_of(towers(), {.from_deg = 0.0, .tilt_deg = 10.0, .width_px = 400}, {});
  const Picture low = picture_of(towers(), {.from_deg = 0.0, .tilt_deg = 10.0, .high_m = 2.0, .width_px = 400}, {});
  EXPECT_LT(low.height, all.height);
  EXPECT_THROW(picture_of(towers(), {.low_m = 10.0}, {}), Error);
}

TEST(OctreePicture, ThePathIsAboveTheVoxels) {
  const std::vector<Eigen::Vector3d> path{{0.5, 0.0, 1.0}, {0.5, 11.0, 1.0}};
  const OctreeView view{.from_deg = 0.0, .tilt_deg = 10.0, .width_px = 400};
  EXPECT_NE(picture_of(towers(), view, path).rgb, picture_of(towers(), view, {}).rgb);
}

TEST(OctreePicture, IsWrittenAsPng) {
  const test::TemporaryFolder folder;
  write_png(picture_of(towers(), {}, {}), folder / "towers.png");
  std::ifstream file(folder / "towers.png", std::ios::binary);
  std::string begin(8, ' ');
  file.read(begin.data(), 8);
  EXPECT_EQ(begin, "\x89PNG\r\n\x1a\n");
  EXPECT_THROW(write_png(picture_of(towers(), {}, {}), folder / "none" / "towers.png"), Error);
}

}  // namespace
}  // namespace waymark::maps
