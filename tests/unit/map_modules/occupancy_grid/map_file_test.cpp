// SPDX-License-Identifier: Apache-2.0
#include "map_modules/occupancy_grid/map_file.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>

#include "simulated_room.hpp"
#include "temporary_folder.hpp"
#include "waymark/error.hpp"
#include "waymark/plugin_loader.hpp"

namespace waymark::grid_test {
namespace {

using ::testing::HasSubstr;

/// A folder of its own with a map of 4 × 3 pixels: one occupied, the others free, the last row unknown.
class MapFile : public ::testing::Test {
 protected:
  MapFile() {
    write("map.yaml", yaml_);
    write("map.pgm", "P5\n# drawn by hand\n4 3\n255\n" + pixels_);
  }

  void write(const char* name, const std::string& content) const {
    std::ofstream(folder_ / name, std::ios::binary) << content;
  }
  LoadedMap load() const { return load_map_file(folder_ / "map.yaml", settings().odds); }
  std::string message() const {
    try {
      load();
    } catch (const Error& error) {
      return error.what();
    }
    return "none";
  }

  test::TemporaryFolder folder_;
  std::string yaml_ =
      "image: map.pgm\nresolution: 0.1\norigin: [-1.03, 2.5, 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: "
      "0.196\n";
  std::string pixels_ = std::string("\xfe\xfe\x00\xfe", 4) + std::string(4, '\xfe') + std::string(4, '\xcd');
};

TEST_F(MapFile, IsReadAsItIsDrawn) {
  const LoadedMap map = load();
  EXPECT_DOUBLE_EQ(map.resolution, 0.1);
  EXPECT_DOUBLE_EQ(map.corner.x(), -1.03);
  const Tile& tile = map.tiles.read({0, 0});
  EXPECT_EQ(tile.odds[Tile::place(2, 2)], 35);
  EXPECT_EQ(tile.odds[Tile::place(1, 2)], -20);
  EXPECT_EQ(tile.odds[Tile::place(2, 1)], -20);
  EXPECT_EQ(tile.odds[Tile::place(2, 0)], Tile::kUnknown);
  EXPECT_EQ(tile.odds[Tile::place(4, 0)], Tile::kUnknown);
  EXPECT_EQ(tile.distance[Tile::place(2, 2)], 0);
  EXPECT_EQ(tile.distance[Tile::place(2, 0)], 2 * Tile::kDistanceSteps);
  EXPECT_EQ(map.tiles.read({-1, 0}).distance[Tile::place(-2, 2)], 4 * Tile::kDistanceSteps);
}

TEST_F(MapFile, NegatedItIsTheOtherWayRound) {
  write("map.yaml", yaml_ + "mode: trinary\n");
  yaml_.replace(yaml_.find("negate: 0"), 9, "negate: 1");
  write("map.yaml", yaml_);
  EXPECT_EQ(load().tiles.read({0, 0}).odds[Tile::place(2, 2)], -20);
}

TEST_F(MapFile, TellsWhatIsWrong) {
  write("map.pgm", "P5\n4 3\n255\n" + pixels_.substr(1));
  EXPECT_THAT(message(), HasSubstr("map.pgm: 4 x 3 pixels are 12 bytes, but 11 are there"));
  write("map.pgm", "P5\n4 3\n255\n" + pixels_ + "x");
  EXPECT_THAT(message(), HasSubstr("but 13 are there"));
  write("map.pgm", "P5\n400000 300000\n255\n" + pixels_);
  EXPECT_THAT(message(), HasSubstr("400000 x 300000 pixels; a map has from 1 to"));
  write("map.pgm", "P5\n4 3\n65535\n" + pixels_ + pixels_);
  EXPECT_THAT(message(), HasSubstr("the largest value is 65535"));
  write("map.pgm", "P5\nfour 3\n255\n" + pixels_);
  EXPECT_THAT(message(), HasSubstr("no width"));
  write("map.pgm", "P5\n4");
  EXPECT_THAT(message(), HasSubstr("no width"));
  write("map.pgm", "P2\n4 3\n255\n");
  EXPECT_THAT(message(), HasSubstr("must begin with P5"));
  std::filesystem::remove(folder_ / "map.pgm");
  EXPECT_THAT(message(), HasSubstr("map.pgm: not found"));

  write("map.yaml", "image: map.pgm\nresolution: 0.1\n");
  EXPECT_THAT(message(), HasSubstr("origin"));
  write("map.yaml", yaml_ + "mode: scale\n");
  EXPECT_THAT(message(), HasSubstr("mode"));
  write("map.yaml", yaml_ + "free_tresh: 0.1\n");
  EXPECT_THAT(message(), HasSubstr("unknown key"));
  yaml_.replace(yaml_.find("0.0]"), 4, "0.3]");
  write("map.yaml", yaml_);
  EXPECT_THAT(message(), HasSubstr("the yaw, must be 0"));
}

TEST_F(MapFile, ALoadedMapIsMatchedWhereItLies) {
  // What was mapped is written as the sink writes it, and read back: the same free and occupied cells.
  const TileTree tiles = mapped(room(), {{0, 0, 0}, {0, 0, 3.1}, {4, 0, 1.5}});
  const auto model = std::make_shared<GridModel>(settings());
  std::optional<GridView> before;
  {
    ParticleGrid grid(model);
    const ScanObservation scan = observed(room(), {0, 0, 0});
    Refinement refinement;
    grid.refine({Pose{}, Eigen::Matrix3d::Zero()}, Pose{}, scan, refinement);
    grid.insert({Pose{}, Eigen::Matrix3d::Zero()}, scan, refinement.association.get());
    before = grid.grid();
  }
  ASSERT_TRUE(before);
  std::string pixels;
  for (int row = before->height - 1; row >= 0; --row) {
    for (int column = 0; column < before->width; ++column) {
      const int p = before->cells[static_cast<std::size_t>(row * before->width + column)];
      pixels += static_cast<char>(p == GridView::kUnknown ? 205 : p > 50 ? 0 : 254);
    }
  }
  write("map.pgm", fmt::format("P5\n{} {}\n255\n", before->width, before->height) + pixels);
  const Eigen::Vector3d corner = before->T_map_grid.p;
  write("map.yaml", fmt::format("image: map.pgm\nresolution: 0.05\norigin: [{}, {}, 0]\nnegate: 0\noccupied_thresh: "
                                "0.65\nfree_thresh: 0.196\n",
                                corner.x(), corner.y()));
  OccupancyGridSettings localize = settings();
  localize.use = MapUse::localize;
  localize.load = folder_ / "map.yaml";
  ParticleGrid grid(std::make_shared<GridModel>(localize));

  const std::optional<GridView> after = grid.grid();
  ASSERT_TRUE(after);
  ASSERT_EQ(after->cells.size(), before->cells.size());
  for (std::size_t i = 0; i < after->cells.size(); ++i) {
    EXPECT_EQ(after->cells[i] == GridView::kUnknown, before->cells[i] == GridView::kUnknown);
    EXPECT_EQ(after->cells[i] > 50, before->cells[i] > 50);
  }
  EXPECT_LT((after->T_map_grid.p - corner).norm(), 1e-9);

  const Eigen::Vector3d truth(0.05, -0.04, 0.02);
  Refinement refinement;
  const Eigen::Matrix3d P = Eigen::Vector3d(0.01, 0.01, 0.001).asDiagonal();
  grid.refine({Pose{}, P}, Pose{}, observed(room(), truth), refinement);
  EXPECT_FALSE(refinement.writes);
  const Eigen::Vector3d found =
      P * (Eigen::Matrix3d::Identity() + refinement.information * P).inverse() * refinement.gradient;
  EXPECT_LT((found - truth).head<2>().norm(), 0.025);
  const TileTree untouched = grid.tiles();
  grid.insert({Pose{}, P}, observed(room(), truth), refinement.association.get());
  EXPECT_TRUE(grid.tiles().shares_root_with(untouched));
}

TEST_F(MapFile, MustHaveTheCellsOfTheModule) {
  OccupancyGridSettings localize = settings();
  localize.use = MapUse::localize;
  localize.load = folder_ / "map.yaml";
  EXPECT_THROW(GridModel{localize}, DataError);
}

TEST(OccupancyGridSettings, AMapAndItsModeBelongTogether) {
  EXPECT_THROW(settings("{ load: map.yaml }"), ConfigError);
  EXPECT_THROW(settings("{ mode: localize }"), ConfigError);
  EXPECT_THROW(settings("{ load: map.yaml, mode: fly }"), ConfigError);
}

}  // namespace
}  // namespace waymark::grid_test
