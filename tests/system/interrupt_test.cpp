// SPDX-License-Identifier: Apache-2.0
// needs plugins: dgps, diagnostics, feature_map, landmarks, odometry, plot, simulator, tum
// Ctrl-C ends a run cleanly.
#include <gmock/gmock.h>

#include <csignal>
#include <nlohmann/json.hpp>

#include "tests/system/command.hpp"

namespace waymark::system_test {
namespace {

using testing::HasSubstr;
using testing::SizeIs;

class Interrupt : public testing::TestWithParam<int> {};

TEST_P(Interrupt, EndsALongRunWithItsOutputsWritten) {
  const TemporaryFolder folder;
  const std::filesystem::path out = folder / "out";
  const std::filesystem::path trajectory = out / "trajectory.txt.partial";
  // 30 laps and an hour of log: far longer than it takes to be interrupted.
  Command command({"run", WAYMARK_SOURCE_DIR "/config/quickstart.yaml", "--out", out.string(), "--set",
                   "source.duration_s=3600", "--set", "source.course.laps=30", "--set", "filter.particles=5"});
  const auto is_under_way = [&] {
    std::error_code error;
    const auto size = std::filesystem::file_size(trajectory, error);
    return !error && size > 0;
  };
  const Outcome outcome = command.send(GetParam(), is_under_way).run();
  EXPECT_EQ(outcome.exit_code, 130) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("interrupted"));
  EXPECT_THAT(outcome.errors(), SizeIs(0));
  for (const char* name : {"trajectory.txt", "path.txt", "landmarks.csv"})
    EXPECT_TRUE(has_complete_lines(out / name, 1));
  EXPECT_GT(std::filesystem::file_size(out / "map.png"), 1000u);
  EXPECT_TRUE(has_no_partial_file(out));
  const nlohmann::json report = nlohmann::json::parse(read_text(out / "diagnostics.json"));
  EXPECT_EQ(report["run"]["interrupted"], true);
  EXPECT_LT(report["run"]["duration_s"].get<double>(), 3590.0);
}

INSTANTIATE_TEST_SUITE_P(Run, Interrupt, testing::Values(SIGINT, SIGTERM, SIGHUP), [](const auto& number) {
  return number.param == SIGINT ? "CtrlC" : number.param == SIGTERM ? "Terminate" : "HangUp";
});

}  // namespace
}  // namespace waymark::system_test
