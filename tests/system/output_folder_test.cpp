// SPDX-License-Identifier: Apache-2.0
// needs plugins: csv, diagnostics, dgps, feature_map, landmarks, odometry, tum
// A run owns its output folder, and its configuration can be run from there.
#include <gmock/gmock.h>
#include <unistd.h>

#include "tests/system/small_robot.hpp"

namespace waymark::system_test {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(OutputFolder, ARunWithFewerOutputsLeavesNoneOfAnEarlierRun) {
  SmallRobot robot;
  const Outcome first = robot.run();
  ASSERT_EQ(first.exit_code, 0) << first.err;
  EXPECT_THAT(first.err, Not(HasSubstr("earlier run")));
  write_text(robot.out() / "notes.txt", "mine\n");
  const Outcome second = robot.run({"--set", "sinks.landmarks.enabled=false"});
  ASSERT_EQ(second.exit_code, 0) << second.err;
  EXPECT_THAT(second.err, HasSubstr("the results of an earlier run are replaced; removed: landmarks.csv"));
  EXPECT_FALSE(std::filesystem::exists(robot.out() / "landmarks.csv"));
  EXPECT_TRUE(std::filesystem::exists(robot.out() / "trajectory.txt"));
  EXPECT_EQ(read_text(robot.out() / "notes.txt"), "mine\n");
}

TEST(OutputFolder, ItsConfigurationRunsFromWhereItLies) {
  SmallRobot robot;
  ASSERT_EQ(robot.run({"--seed", "3"}).exit_code, 0);
  const std::filesystem::path again = robot.file("again");
  const std::string config = (robot.out() / "config.yaml").string();
  const Outcome outcome = Command({"run", config, "--out", again.string()})
                              .in_child([] {
                                if (::chdir("/") != 0) ::_exit(126);
                              })
                              .run();
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(read_text(again / "trajectory.txt"), read_text(robot.out() / "trajectory.txt"));
  // And so does that of the second run.
  EXPECT_EQ(waymark({"check", (again / "config.yaml").string()}).exit_code, 0);
}

TEST(OutputFolder, AWrongValueInAConfigurationOfARunIsReportedAtItsOwnPlace) {
  SmallRobot robot;
  ASSERT_EQ(robot.run().exit_code, 0);
  const std::filesystem::path config = robot.out() / "config.yaml";
  std::string text = read_text(config);
  text.replace(text.find("twist.csv"), 9, "twost.csv");
  write_text(config, text);
  EXPECT_TRUE(reports_error(waymark({"check", config.string()}), 1, {robot.file("twost.csv").string()}));
}

}  // namespace
}  // namespace waymark::system_test
