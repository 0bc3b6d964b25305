// SPDX-License-Identifier: Apache-2.0
// needs plugins: carmen, diagnostics, grid_map, occupancy_grid, odometry, plot, tum
// Loops on a recording of 1.9 km, whose large loops particles alone do not close.
#include <gmock/gmock.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <vector>

#include "tests/system/outputs.hpp"

namespace waymark::system_test {
namespace {

std::vector<std::string> corridor(const std::filesystem::path& out) {
  return {"run",
          WAYMARK_SOURCE_DIR "/config/carmen_sparse.yaml",
          "--quiet",
          "--out",
          out.string(),
          "--set",
          "variables.place=infinite-corridor",
          "--set",
          "variables.times=lines",
          "--set",
          "variables.laser_x_m=0"};
}

/// When loops moved the maps of a run [s].
std::vector<double> loops_of(const std::filesystem::path& out) {
  const auto diagnostics = nlohmann::json::parse(std::ifstream(out / "diagnostics.json"));
  std::vector<double> times;
  for (const auto& event : diagnostics.at("run").at("events")) {
    if (event.at("text").get<std::string>().find("a loop of") != std::string::npos) times.push_back(event.at("t_s"));
  }
  return times;
}

TEST(Loops, ACampusOfCorridorsIsDrawnOnce) {
  if (data_folder().empty()) GTEST_SKIP() << "WAYMARK_DATA is not set";
  const TemporaryFolder folder;
  const std::filesystem::path out = folder / "out";
  const Outcome outcome = waymark(corridor(out));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_GE(loops_of(out).size(), 3U);
  // A loop makes the position certain again, also far from the place where it was closed: else its σ would exceed 10 m
  // for a quarter of the time.
  const auto health = nlohmann::json::parse(std::ifstream(out / "diagnostics.json")).at("health");
  const double ok = health.at("ok_s");
  EXPECT_GT(ok, 0.87 * (ok + health.at("degraded_s").get<double>() + health.at("lost_s").get<double>()));
}

TEST(Loops, CanBeSwitchedOff) {
  if (data_folder().empty()) GTEST_SKIP() << "WAYMARK_DATA is not set";
  const TemporaryFolder folder;
  const std::filesystem::path out = folder / "out";
  std::vector<std::string> arguments = corridor(out);
  arguments.insert(arguments.end(), {"--set", "loops.enabled=false"});
  ASSERT_EQ(waymark(arguments).exit_code, 0);
  EXPECT_EQ(loops_of(out).size(), 0U);
}

TEST(Loops, ACorrectionGoesOnFromACheckpoint) {
  if (data_folder().empty()) GTEST_SKIP() << "WAYMARK_DATA is not set";
  const TemporaryFolder folder;
  const auto run = [&](const std::filesystem::path& out, double until, std::vector<std::string> more) {
    std::vector<std::string> arguments = corridor(out);
    arguments.insert(arguments.end(), {"--until", std::to_string(until)});
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome outcome = waymark(arguments);
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  };
  run(folder / "whole", 330.0, {});
  const std::vector<double> loops = loops_of(folder / "whole");
  ASSERT_FALSE(loops.empty()) << "no loop was closed";
  const std::string whole = read_text(folder / "whole" / "path.txt");
  ASSERT_FALSE(whole.empty());
  // The maps are drawn again in the mapping steps before; scans are about a second apart.
  const std::string checkpoint = (folder / "half.ckpt").string();
  for (const double before : {1.0, 2.0, 3.0, 4.0}) {
    run(folder / "first", loops.front() - before, {"--save", checkpoint});
    run(folder / "second", 330.0, {"--resume", checkpoint});
    EXPECT_EQ(read_text(folder / "second" / "path.txt"), whole) << before << " s before";
  }
}

}  // namespace
}  // namespace waymark::system_test
