// SPDX-License-Identifier: Apache-2.0
// needs plugins: diagnostics, grid_map, occupancy_grid, odometry, plot, simulator, tum
// A robot maps a room, finds its way in the map that it has written, and does both the same with any number of threads.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "tests/system/outputs.hpp"

namespace waymark::system_test {
namespace {

/// Runs config/indoor.yaml without the picture.
Outcome indoor(const std::filesystem::path& out, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {"run", WAYMARK_SOURCE_DIR "/config/indoor.yaml", "--quiet", "--set",
                                       "sinks.plot.enabled=false", "--out", out.string()});
  return Command(std::move(arguments)).timeout(std::chrono::seconds(500)).run();
}

nlohmann::json score(const std::filesystem::path& out) {
  const Outcome outcome = Command({"evaluate", "--json", "--estimate", (out / "trajectory.txt").string(), "--reference",
                                   (out / "reference.txt").string()})
                              .run();
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  return nlohmann::json::parse(outcome.out);
}

double position_rms(const std::filesystem::path& out) { return score(out).at("trajectory").at("ate_rms_m"); }

TEST(OccupancyGridRun, MapsARoomAndFindsItsWayInTheFile) {
  const TemporaryFolder folder;
  Outcome outcome = indoor(folder / "mapped", {});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_LT(position_rms(folder / "mapped"), 0.1);

  // The room has 10 m × 8 m of cells of 5 cm; outside of it there is a cell or two of noise.
  const std::string pgm = read_text(folder / "mapped/room.pgm");
  int width = 0;
  int height = 0;
  ASSERT_EQ(std::sscanf(pgm.c_str(), "P5\n%d %d\n", &width, &height), 2);
  EXPECT_NEAR(width, 204, 8);
  EXPECT_NEAR(height, 164, 8);
  EXPECT_THAT(read_text(folder / "mapped/room.yaml"), testing::HasSubstr("resolution: 0.05"));

  const std::string file = (folder / "mapped/room.yaml").string();
  outcome = indoor(folder / "localized",
                   {"--set", "maps.room.load=" + file, "--set", "maps.room.mode=localize", "--set", "source.seed=5"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_LT(position_rms(folder / "localized"), 0.1);
  // Nothing was written into it.
  EXPECT_EQ(read_text(folder / "localized/room.pgm"), pgm);
}

TEST(OccupancyGridRun, OneTwoAndFourThreadsGiveTheSameBytes) {
  const TemporaryFolder folder;
  for (const char* threads : {"1", "2", "4"}) {
    const Outcome outcome = indoor(folder / threads, {"--threads", threads, "--set", "source.duration_s=25"});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  }
  const auto one = contents(folder / "1", {"config.yaml"});
  EXPECT_THAT(one, testing::Contains(testing::Key("room.pgm")));
  EXPECT_TRUE(same_bytes(one, contents(folder / "2", {"config.yaml"})));
  EXPECT_TRUE(same_bytes(one, contents(folder / "4", {"config.yaml"})));
}

TEST(OccupancyGridRun, TellsWhatIsWrongWithAMap) {
  const TemporaryFolder folder;
  write_text(folder / "map.yaml",
             "image: map.pgm\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\n"
             "free_thresh: 0.196\n");
  write_text(folder / "map.pgm", "P5\n30 40\n255\nshort");
  const Outcome outcome = indoor(folder / "out", {"--set", "maps.room.load=" + (folder / "map.yaml").string(), "--set",
                                                  "maps.room.mode=localize"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, testing::HasSubstr("map.pgm: 30 x 40 pixels are 1200 bytes, but 5 are there"));
}

}  // namespace
}  // namespace waymark::system_test
