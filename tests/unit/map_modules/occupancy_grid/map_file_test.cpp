// SPDX-License-Identifier: Apache-2.0
#include "map_modules/occupancy_grid/map_file.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>

#include "temporary_folder.hpp"
#include "tests/unit/map_modules/occupancy_grid/simulated_room.hpp"
#include "waymark/base/error.hpp"
#include "waymark/math/gaussian.hpp"
#include "waymark/math/random.hpp"
#include "waymark/plugin_loader.hpp"

namespace waymark::occupancy_grid_test {
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
  EXPECT_DOUBLE_EQ(map.T_map_grid.p.x(), -1.03);
  const Tile& tile = map.tiles.read({0, 0});
  EXPECT_EQ(tile.odds[Tile::place(2, 2)], 35);
  EXPECT_EQ(tile.odds[Tile::place(1, 2)], -20);
  EXPECT_EQ(tile.odds[Tile::place(2, 1)], -20);
  EXPECT_EQ(tile.odds[Tile::place(2, 0)], Tile::kUnknown);
  EXPECT_EQ(tile.odds[Tile::place(4, 0)], Tile::kUnknown);
  EXPECT_EQ(tile.distances[Tile::place(2, 2)], 0);
  EXPECT_EQ(tile.distances[Tile::place(2, 0)], 2 * Tile::kDistanceSteps);
  EXPECT_EQ(map.tiles.read({-1, 0}).distances[Tile::place(-2, 2)], 4 * Tile::kDistanceSteps);
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
  EXPECT_THAT(message(), HasSubstr("it begins with \"P2\", P5 is expected"));
  std::filesystem::remove(folder_ / "map.pgm");
  EXPECT_THAT(message(), HasSubstr("map.pgm: not found"));

  write("map.yaml", "image: map.pgm\nresolution: 0.1\n");
  EXPECT_THAT(message(), HasSubstr("origin"));
  write("map.yaml", yaml_ + "mode: scale\n");
  EXPECT_THAT(message(), HasSubstr("mode"));
  write("map.yaml", yaml_ + "free_tresh: 0.1\n");
  EXPECT_THAT(message(), HasSubstr("unknown key"));
}

/// A map of the room, drawn as the sink does it, and loaded where the YAML says that it lies.
class LoadedRoom : public MapFile {
 protected:
  LoadedRoom() {
    ParticleGrid drawn(std::make_shared<GridModel>(settings()));
    for (const Eigen::Vector3d& at : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0, 0, 3.1), Eigen::Vector3d(4, 0, 1.5)})
      insert(drawn, at);
    drawn_ = drawn.grid().value();
    std::string pixels;
    for (int row = drawn_.height - 1; row >= 0; --row) {
      for (int column = 0; column < drawn_.width; ++column) {
        const int p = drawn_.cells[static_cast<std::size_t>(row * drawn_.width + column)];
        pixels += static_cast<char>(p == GridView::kUnknown ? 205 : p > 50 ? 0 : 254);
      }
    }
    write("map.pgm", fmt::format("P5\n{} {}\n255\n", drawn_.width, drawn_.height) + pixels);
  }

  static void insert(ParticleGrid& grid, const Eigen::Vector3d& at) {
    const ScanObservation scan = observed(room(), at);
    const PoseGaussian pose{Pose::planar(at.x(), at.y(), at.z()), Eigen::Matrix3d::Zero()};
    Refinement refinement;
    grid.refine(pose, pose.T_map_base, scan, refinement);
    grid.insert(pose, scan, refinement.association.get());
  }
  /// The room at `T_map_room`.
  ParticleGrid loaded(const Pose& T_map_room = {}) const {
    const Pose corner = T_map_room * drawn_.T_map_grid;
    write("map.yaml", fmt::format("image: map.pgm\nresolution: 0.05\norigin: [{}, {}, {}]\nnegate: 0\n"
                                  "occupied_thresh: 0.65\nfree_thresh: 0.196\n",
                                  corner.p.x(), corner.p.y(), corner.yaw()));
    OccupancyGridSettings localize = settings();
    localize.load.use = map_formats::MapUse::localize;
    localize.load.file = folder_ / "map.yaml";
    return ParticleGrid(std::make_shared<GridModel>(localize));
  }
  static Eigen::Vector3d found(const Refinement& refinement, const Eigen::Matrix3d& P) {
    return P * (Eigen::Matrix3d::Identity() + refinement.information * P).inverse() * refinement.gradient;
  }

  GridView drawn_;
};

TEST_F(LoadedRoom, HasTheSameFreeAndOccupiedCells) {
  const std::optional<GridView> after = loaded().grid();
  ASSERT_TRUE(after);
  ASSERT_EQ(after->cells.size(), drawn_.cells.size());
  for (std::size_t i = 0; i < after->cells.size(); ++i) {
    EXPECT_EQ(after->cells[i] == GridView::kUnknown, drawn_.cells[i] == GridView::kUnknown);
    EXPECT_EQ(after->cells[i] > 50, drawn_.cells[i] > 50);
  }
  EXPECT_LT((after->T_map_grid.p - drawn_.T_map_grid.p).norm(), 1e-9);
}

TEST_F(LoadedRoom, IsMatchedAndLeftAsItIs) {
  ParticleGrid grid = loaded();
  const Eigen::Vector3d truth(0.05, -0.04, 0.02);
  Refinement refinement;
  const Eigen::Matrix3d P = Eigen::Vector3d(0.01, 0.01, 0.001).asDiagonal();
  grid.refine({Pose{}, P}, Pose{}, observed(room(), truth), refinement);
  EXPECT_FALSE(refinement.writes);
  EXPECT_LT((found(refinement, P) - truth).head<2>().norm(), 0.025);
  const TileTree untouched = grid.tiles();
  grid.insert({Pose{}, P}, observed(room(), truth), refinement.association.get());
  EXPECT_TRUE(grid.tiles().shares_root_with(untouched));
}

TEST_F(LoadedRoom, MayLieTurned) {
  // The same match, seen from a map's frame in which the room is turned.
  const Pose T_map_room = Pose::planar(20.0, -7.0, 0.6);
  const ScanObservation scan = observed(room(), {0.05, -0.04, 0.02});
  const Eigen::Matrix3d P = Eigen::Vector3d(0.01, 0.01, 0.001).asDiagonal();
  Refinement straight;
  loaded().refine({Pose{}, P}, Pose{}, scan, straight);
  const ParticleGrid grid = loaded(T_map_room);
  Refinement turned;
  grid.refine({T_map_room, P}, T_map_room, scan, turned);
  EXPECT_LT((found(turned, P) - T_map_room.q * found(straight, P)).norm(), 1e-6);
  EXPECT_GT(found(straight, P).norm(), 0.05);
  EXPECT_NEAR(turned.log_evidence, straight.log_evidence, 1e-4);
  const std::optional<GridView> view = grid.grid();
  ASSERT_TRUE(view);
  EXPECT_NEAR(view->T_map_grid.yaw(), 0.6, 1e-9);
}

TEST_F(LoadedRoom, IsSearchedThroughoutByAParticleThatKnowsNothing) {
  const ParticleGrid grid = loaded();
  const Eigen::Vector3d truth(2.5, 0.8, 2.4);
  const ScanObservation scan = observed(room(), truth, 0.01);
  const Eigen::Matrix3d P = Eigen::Vector3d(16.0, 9.0, 9.9).asDiagonal();  // σ of 4 m, 3 m and 180°
  Random random({.seed = 3, .slot = 0, .stamp = 1, .sensor = 1});
  int right = 0;
  double best_right = -1e9;
  double best_wrong = -1e9;
  constexpr int kParticles = 20;
  for (int k = 0; k < kParticles; ++k) {
    const Eigen::Vector3d draw = gaussian::sample(P, random);
    Refinement refinement;
    grid.refine({Pose{}, P}, Pose::planar(draw.x(), draw.y(), draw.z()), scan, refinement);
    Eigen::Vector3d error = found(refinement, P) - truth;
    error.z() = so3::wrap(error.z());
    const bool is_right = error.head<2>().norm() < 0.05 && std::abs(error.z()) < 0.02;
    right += is_right;
    double& best = is_right ? best_right : best_wrong;
    best = std::max(best, refinement.log_evidence);
  }
  EXPECT_GE(right, kParticles / 2);
  EXPECT_GT(best_right, best_wrong);
}

TEST_F(MapFile, MustHaveTheCellsOfTheModule) {
  OccupancyGridSettings localize = settings();
  localize.load.use = map_formats::MapUse::localize;
  localize.load.file = folder_ / "map.yaml";
  EXPECT_THROW(GridModel{localize}, DataError);
}

TEST(OccupancyGridSettings, AMapAndItsModeBelongTogether) {
  EXPECT_THROW(settings("{ load: map.yaml }"), ConfigError);
  EXPECT_THROW(settings("{ mode: localize }"), ConfigError);
  EXPECT_THROW(settings("{ load: map.yaml, mode: fly }"), ConfigError);
}

}  // namespace
}  // namespace waymark::occupancy_grid_test
