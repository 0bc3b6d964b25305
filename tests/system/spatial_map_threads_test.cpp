// SPDX-License-Identifier: Apache-2.0
// needs plugins: diagnostics, grid_map, imu, map_files, octomap_grid, odometry, plot, simulator, tum
// A dense map that is matched in six degrees of freedom: the same with any number of threads.
#include <gmock/gmock.h>

#include "tests/system/outputs.hpp"

namespace waymark::system_test {
namespace {

TEST(SpatialMapThreads, OneAndTwoThreadsGiveTheSameBytes) {
  const TemporaryFolder folder;
  for (const char* threads : {"1", "2"}) {
    const Outcome outcome = Command({"run", WAYMARK_SOURCE_DIR "/config/ramp_3d.yaml", "--quiet", "--set",
                                     "sinks.plot.enabled=false", "--until", "5", "--set", "filter.particles=4",
                                     "--threads", threads, "--out", (folder / threads).string()})
                                .timeout(std::chrono::seconds(500))
                                .run();
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  }
  EXPECT_TRUE(same_bytes(contents(folder / "1", {"config.yaml"}), contents(folder / "2", {"config.yaml"})));
}

}  // namespace
}  // namespace waymark::system_test
