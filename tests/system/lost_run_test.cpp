// SPDX-License-Identifier: Apache-2.0
// needs plugins: dgps, diagnostics, odometry, simulator, tum
// A run whose pose was lost for too large a share of its time has its own exit code, and says so last.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "tests/system/outputs.hpp"

namespace waymark::system_test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

/// Without fixes from 10 s to 110 s, and with wheels whose position is unknown by 20 m after 100 s.
constexpr const char* kRobot = R"(source:
  plugin: simulator
  duration_s: 120
  course: { waypoints_m: [0, 0, 30, 0, 30, 20, 0, 20] }
  wheels: { sensor: wheels, rate_hz: 10, track_m: 0.5 }
  gps: { sensor: gps, rate_hz: 2, outages_s: [10, 110] }
initial: { x_m: 0, y_m: 0, position_sigma_m: 0.3, yaw_deg: 0, yaw_sigma_deg: 2 }
sensors:
  - { name: wheels, plugin: odometry, model: differential, track_m: 0.5, speed_noise_m_per_sqrt_s: [2, 0] }
  - { name: gps, plugin: dgps, base_p_antenna_m: none }
sinks: [{ plugin: tum }, { plugin: diagnostics }]
)";

TEST(LostRun, EndsWithItsOwnExitCodeAndSaysSoLast) {
  const TemporaryFolder folder;
  write_text(folder / "robot.yaml", kRobot);
  const std::string out = folder / "out";
  const Outcome outcome = waymark({"run", folder / "robot.yaml", "--out", out});
  EXPECT_EQ(outcome.exit_code, 4) << outcome.err;
  ASSERT_EQ(outcome.errors().size(), 1U);
  EXPECT_THAT(outcome.errors()[0], HasSubstr("waymark: error: the pose was lost for "));
  EXPECT_THAT(outcome.errors()[0], HasSubstr(" % of the run; health.max_lost_share allows 10 %"));
  EXPECT_EQ(lines_of(outcome.err).back(), outcome.errors()[0]);
  const auto health = nlohmann::json::parse(read_text(folder / "out/diagnostics.json")).at("health");
  EXPECT_GT(health.at("lost_s").get<double>(), 50.0);
  EXPECT_TRUE(has_complete_lines(folder / "out/trajectory.txt", 5));
}

TEST(LostRun, TheShareIsAKeyOfTheYaml) {
  const TemporaryFolder folder;
  write_text(folder / "robot.yaml", kRobot);
  const std::string out = folder / "out";
  const Outcome outcome = waymark({"run", folder / "robot.yaml", "--out", out, "--set", "health.max_lost_share=0.9"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.errors(), IsEmpty());
}

}  // namespace
}  // namespace waymark::system_test
