// SPDX-License-Identifier: Apache-2.0
// needs plugins: occupancy_grid, odometry, simulator, tum
// A robot that starts elsewhere in a loaded map than its YAML has it: it is noticed, and found.
#include <gmock/gmock.h>

#include <Eigen/Core>
#include <sstream>

#include "tests/system/outputs.hpp"

namespace waymark::system_test {
namespace {

using testing::HasSubstr;
using testing::Not;

/// A room that looks the same from nowhere else.
const std::string kWalls =
    "source.walls_m=[-2.02, -2.02, 8.02, -2.02, 8.02, -2.02, 8.02, 4.02, 8.02, 4.02, 5.02, 6.02, 5.02, 6.02, -2.02, "
    "6.02, -2.02, 6.02, -2.02, -2.02, 2.02, 1.52, 4.02, 1.52, 4.02, 1.52, 3.02, 2.52, 3.02, 2.52, 2.02, 1.52]";

class Relocation : public ::testing::Test {
 protected:
  Outcome drive(const std::string& out, const std::vector<std::string>& settings) {
    std::vector<std::string> arguments{
        "run", WAYMARK_SOURCE_DIR "/config/indoor.yaml", "--quiet", "--out", at(out), "--set", kWalls};
    for (const std::string& setting : settings) arguments.insert(arguments.end(), {"--set", setting});
    return waymark(arguments);
  }
  /// A later drive from the middle of the course, where the YAML has the robot at its begin, turned round.
  Outcome drive_again(const std::string& out, const std::string& setting) {
    return drive(out, {"maps.room.load=" + at("first/room.yaml"), "maps.room.mode=localize", "source.seed=2",
                       "initial={ x_m: 5, y_m: 4, yaw_deg: 120 }", "health.max_lost_share=0.3", setting});
  }
  /// At the end of a drive, to where the simulator has the robot [m].
  double end_error(const std::string& out) const {
    const Eigen::Vector2d off = last_position(out + "/trajectory.txt") - last_position(out + "/reference.txt");
    return off.norm();
  }
  Eigen::Vector2d last_position(const std::string& name) const {
    const std::string text = read_text(folder_ / name);
    std::istringstream row(text.substr(text.rfind('\n', text.size() - 2) + 1));
    double t = 0.0;
    Eigen::Vector2d p;
    row >> t >> p.x() >> p.y();
    return p;
  }
  std::string at(const std::string& name) const { return (folder_ / name).string(); }

  TemporaryFolder folder_;
};

TEST_F(Relocation, FindsARobotThatStartsElsewhere) {
  Outcome outcome = drive("first", {});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;

  outcome = drive_again("found", "relocation.enabled=true");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("the robot was found in the loaded map"));
  EXPECT_LT(end_error("found"), 0.1);
  EXPECT_THAT(read_text(folder_ / "found/diagnostics.json"), HasSubstr("position and heading began anew"));

  outcome = drive_again("astray", "relocation.enabled=false");
  EXPECT_THAT(outcome.err, Not(HasSubstr("was found")));
  EXPECT_GT(end_error("astray"), 1.0);
}

}  // namespace
}  // namespace waymark::system_test
