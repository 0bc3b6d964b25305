// SPDX-License-Identifier: Apache-2.0
// needs plugins: diagnostics, mcap, occupancy_grid, odometry, recorder, ros2, ros2_publisher, simulator, tum
// A simulated robot in one process publishes its measurements as topics of ROS 2, and waymark runs on them in another.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <nlohmann/json.hpp>
#include <thread>

#include "dds_domain.hpp"
#include "tests/system/command.hpp"

namespace waymark::system_test {
namespace {

using ::testing::HasSubstr;

constexpr const char* kRobot = R"(
source:
  plugin: simulator
  duration_s: 5
  speed_mps: 1.0
  course: {{ waypoints_m: [0, 0, 9, 0, 9, 6, 0, 6] }}
  walls_m: [-3, -3, 12, -3,  12, -3, 12, 9,  12, 9, -3, 9,  -3, 9, -3, -3]
  wheels: {{ sensor: wheels, rate_hz: 50, track_m: 0.5 }}
  lidar: {{ sensor: lidar, rate_hz: 5, range_max_m: 15, start_deg: -90, step_deg: 1, beams: 181 }}
live: {{ real_time: true }}
initial: {{ x_m: 0, y_m: 0, yaw_deg: 0 }}
sensors:
  - {{ name: wheels, plugin: odometry, model: differential, track_m: 0.5 }}
  - {{ name: lidar, payload: LaserScan, base_T_sensor: {{ xyz_m: [0.25, 0.0, 0.3], yaw_deg: 90 }} }}
sinks:
  - {{ plugin: ros2_publisher, domain: {0}, publish: [measurements], measurements: {{ topics: {{ wheels: /joint_states, lidar: /scan }} }} }}
)";

constexpr const char* kOnTopics = R"(
source:
  plugin: ros2
  domain: {0}
  channels:
    - {{ topic: /joint_states, type: sensor_msgs/msg/JointState, sensor: wheels, wheels: {{ left: [left_wheel], right: [right_wheel], radius_m: 1 }}, reliable: true }}
    - {{ topic: /scan, type: sensor_msgs/msg/LaserScan, sensor: lidar, reliable: true }}
initial: {{ x_m: 0, y_m: 0, yaw_deg: 0 }}
sensors:
  - {{ name: wheels, plugin: odometry, model: differential, track_m: 0.5 }}
  - {{ name: lidar, payload: LaserScan, base_T_sensor: from_tf }}
maps:
  - {{ name: hall, plugin: occupancy_grid, inputs: [lidar], resolution_m: 0.1, range_max_m: 14, no_return_m: 14.5 }}
filter: {{ particles: 5 }}
record: {{}}
sinks:
  - {{ plugin: ros2_publisher, domain: {0} }}
  - {{ plugin: tum }}
  - {{ plugin: diagnostics }}
)";

TEST(Ros2, ARobotIsRunByItsTopicsAndItsRecordGivesTheSameBytes) {
  const TemporaryFolder folder;
  const std::uint32_t domain = test::own_domain();
  write_text(folder / "robot.yaml", fmt::format(kRobot, domain));
  write_text(folder / "topics.yaml", fmt::format(kOnTopics, domain));
  const std::filesystem::path out = folder / "out";

  std::atomic<bool> has_ended = false;
  Outcome robot;
  std::thread other([&] {
    robot = Command({"run", folder / "robot.yaml", "--out", folder / "robot"}).run();
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    has_ended = true;
  });
  const Outcome run = Command({"run", folder / "topics.yaml", "--out", out})
                          .send(SIGTERM, [&] { return has_ended.load(); })
                          .timeout(std::chrono::seconds(60))
                          .run();
  other.join();
  ASSERT_EQ(robot.exit_code, 0) << robot.err;
  ASSERT_EQ(run.exit_code, 0) << run.err;

  const nlohmann::json report = nlohmann::json::parse(read_text(out / "diagnostics.json"));
  EXPECT_EQ(report.at("run").at("bad_record_count"), 0);
  for (const auto& stream : report.at("live").at("streams")) {
    const bool is_lidar = stream.at("sensor") == "lidar";
    EXPECT_GT(stream.at("received"), is_lidar ? 10 : 100) << stream;
    EXPECT_EQ(stream.at("dropped"), 0);
  }
  EXPECT_THAT(read_text(out / "diagnostics.json"), HasSubstr("/scan: connected"));
  EXPECT_THAT(read_text(out / "diagnostics.json"), HasSubstr("/scan: lost"));
  EXPECT_THAT(read_text(out / "config.yaml"), HasSubstr("xyz_m: [0.25, 0, 0.3]"));
  EXPECT_GT(lines_of(read_text(out / "trajectory.txt")).size(), 100U);

  const std::filesystem::path again = folder / "again";
  const Outcome replay = Command({"run", out / "flight.mcap", "--out", again}).run();
  ASSERT_EQ(replay.exit_code, 0) << replay.err;
  EXPECT_EQ(read_text(again / "trajectory.txt"), read_text(out / "trajectory.txt"));
  EXPECT_EQ(read_text(again / "path.txt"), read_text(out / "path.txt"));
}

TEST(Ros2, WithoutTheTransformOfASensorTheRunDoesNotBegin) {
  const TemporaryFolder folder;
  write_text(folder / "topics.yaml", fmt::format(kOnTopics, test::own_domain()));
  const Outcome run =
      Command({"run", folder / "topics.yaml", "--out", folder / "out", "--set", "source.tf_patience_s=0.5"})
          .timeout(std::chrono::seconds(30))
          .run();
  EXPECT_EQ(run.exit_code, 2) << run.err;
  EXPECT_THAT(run.err, HasSubstr("no message came on /scan within 0.5 s"));
}

}  // namespace
}  // namespace waymark::system_test
