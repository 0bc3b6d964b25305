// SPDX-License-Identifier: Apache-2.0
// needs plugins: diagnostics, grid_map, occupancy_grid, octomap_grid, odometry, plot, simulator, tum
// The octomap grid in place of the occupancy grid: as good, and the same with any number of threads.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "tests/system/outputs.hpp"

namespace waymark::system_test {
namespace {

/// Runs config/indoor.yaml with octrees, without the picture.
Outcome indoor_octomap(const std::filesystem::path& out, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(),
                   {"run", WAYMARK_SOURCE_DIR "/config/indoor.yaml", "--quiet", "--set", "sinks.plot.enabled=false",
                    "--set", "maps.room.plugin=octomap_grid", "--out", out.string()});
  return Command(std::move(arguments)).timeout(std::chrono::seconds(500)).run();
}

TEST(OctomapGridRun, MapsARoomAndTellsWhatParticlesShare) {
  const TemporaryFolder folder;
  double sum = 0.0;
  constexpr int kSeeds = 5;  // one run says little: the wheels drift before the map is closed
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const std::filesystem::path out = folder / std::to_string(seed);
    Outcome outcome = indoor_octomap(out, {"--seed", std::to_string(seed)});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    outcome = Command({"evaluate", "--json", "--estimate", (out / "trajectory.txt").string(), "--reference",
                       (out / "reference.txt").string()})
                  .run();
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    sum += nlohmann::json::parse(outcome.out).at("trajectory").at("ate_rms_m").get<double>();
  }
  EXPECT_LT(sum / kSeeds, 0.1);
  const std::string diagnostics = read_text(folder / "1/diagnostics.json");
  for (const char* figure : {"voxels_occupied", "memory_bytes", "memory_all_bytes", "memory_deep_bytes"})
    EXPECT_THAT(diagnostics, testing::HasSubstr(figure));
}

TEST(OctomapGridRun, OneAndTwoThreadsGiveTheSameBytes) {
  const TemporaryFolder folder;
  for (const char* threads : {"1", "2"}) {
    const Outcome outcome = indoor_octomap(folder / threads, {"--threads", threads, "--set", "source.duration_s=20"});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  }
  const auto one = contents(folder / "1", {"config.yaml"});
  EXPECT_THAT(one, testing::Contains(testing::Key("room.pgm")));
  EXPECT_TRUE(same_bytes(one, contents(folder / "2", {"config.yaml"})));
}

TEST(OctomapGridRun, TellsWhatIsWrongWithAMap) {
  const TemporaryFolder folder;
  write_text(folder / "map.bt", "# Octomap OcTree binary file\nid OcTree\nsize 532566\nres 0.05\ndata\nshort");
  const Outcome outcome = indoor_octomap(
      folder / "out", {"--set", "maps.room.load=" + (folder / "map.bt").string(), "--set", "maps.room.mode=localize"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err,
              testing::HasSubstr("map.bt: truncated: 3 of 532566 nodes are there, the file ends at byte 70"));
}

}  // namespace
}  // namespace waymark::system_test
