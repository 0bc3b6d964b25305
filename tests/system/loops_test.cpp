// SPDX-License-Identifier: Apache-2.0
// needs plugins: carmen, diagnostics, grid_map, occupancy_grid, odometry, plot, tum
// Loops on a recording of 1.9 km, whose large loops particles alone do not close.
#include <gmock/gmock.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

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

/// Events that report a closed loop.
int loops_of(const std::filesystem::path& out) {
  const auto diagnostics = nlohmann::json::parse(std::ifstream(out / "diagnostics.json"));
  int loops = 0;
  for (const auto& event : diagnostics.at("run").at("events"))
    loops += event.at("text").get<std::string>().find("a loop of") != std::string::npos ? 1 : 0;
  return loops;
}

TEST(Loops, ACampusOfCorridorsIsDrawnOnce) {
  if (data_folder().empty()) GTEST_SKIP() << "WAYMARK_DATA is not set";
  const TemporaryFolder folder;
  const std::filesystem::path out = folder / "out";
  const Outcome outcome = waymark(corridor(out));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_GE(loops_of(out), 3);
}

TEST(Loops, CanBeSwitchedOff) {
  if (data_folder().empty()) GTEST_SKIP() << "WAYMARK_DATA is not set";
  const TemporaryFolder folder;
  const std::filesystem::path out = folder / "out";
  std::vector<std::string> arguments = corridor(out);
  arguments.insert(arguments.end(), {"--set", "loops.enabled=false"});
  ASSERT_EQ(waymark(arguments).exit_code, 0);
  EXPECT_EQ(loops_of(out), 0);
}

/// When the first loop of a run moved the maps [s].
double first_loop_of(const std::filesystem::path& out) {
  const auto diagnostics = nlohmann::json::parse(std::ifstream(out / "diagnostics.json"));
  for (const auto& event : diagnostics.at("run").at("events")) {
    if (event.at("text").get<std::string>().find("a loop of") != std::string::npos) return event.at("t_s");
  }
  return -1.0;
}

std::string text_of(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
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
  const double closed = first_loop_of(folder / "whole");
  ASSERT_GT(closed, 0.0) << "no loop was closed";
  const std::string whole = text_of(folder / "whole" / "path.txt");
  ASSERT_FALSE(whole.empty());
  // The maps are drawn again in the mapping steps before; scans are about a second apart.
  const std::string checkpoint = (folder / "half.ckpt").string();
  for (const double before : {1.0, 2.0, 3.0, 4.0}) {
    run(folder / "first", closed - before, {"--save", checkpoint});
    run(folder / "second", 330.0, {"--resume", checkpoint});
    EXPECT_EQ(text_of(folder / "second" / "path.txt"), whole) << before << " s before";
  }
}

}  // namespace
}  // namespace waymark::system_test
