// SPDX-License-Identifier: Apache-2.0
// needs plugins: compass, csv, dgps, imu, log, odometry, rosbag1, simulator
#include <gmock/gmock.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "tests/system/outputs.hpp"

namespace waymark::system_test {
namespace {

using testing::HasSubstr;
using testing::Not;

struct Found {
  double estimated;
  double sigma;
  bool is_determined;
};

std::map<std::string, Found> read_found(const std::filesystem::path& json) {
  std::map<std::string, Found> found;
  for (const auto& row : nlohmann::json::parse(read_text(json)))
    found[row.at("name")] = {row.at("estimated"), row.at("sigma"), row.at("determined")};
  return found;
}

// A log first: the simulator reads the mountings from the same YAML, so it would hide their errors.
TEST(Calibrate, FindsTheErrorsOfASimulatedRobotAndWritesThem) {
  const TemporaryFolder folder;
  const Outcome drive =
      waymark({"run", WAYMARK_SOURCE_DIR "/config/calibration.yaml", "--quiet", "--out", (folder / "drive").string(),
               "--set", "source.duration_s=150", "--set", "sinks=[{plugin: log}]"});
  ASSERT_EQ(drive.exit_code, 0) << drive.err;
  const std::string replay = (folder / "drive/log/replay.yaml").string();
  const Outcome outcome = waymark(
      {"calibrate", replay, "--json", (folder / "found.json").string(), "--out", (folder / "found.yaml").string()});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  std::map<std::string, Found> found = read_found(folder / "found.json");

  // What the comments of config/calibration.yaml say: the wheels give 1.02 and 1.01 of the true speed.
  const double mean = 0.5 * (1.0 / 1.02 + 1.0 / 1.01);
  const std::map<std::string, double> truth{{"wheels.speed_scale", mean},
                                            {"wheels.curvature_per_m", (1.0 / 1.01 - 1.0 / 1.02) / 0.515},
                                            {"wheels.track_m", 0.515},
                                            {"gps.base_p_antenna_m[0]", 0.3},
                                            {"gps.base_p_antenna_m[1]", -0.1},
                                            {"gps.delay_s", 0.1},
                                            {"gps.sigma_m", 0.05},
                                            {"compass.base_T_sensor.yaw_deg", -5.0}};
  for (const auto& [name, value] : truth) {
    ASSERT_TRUE(found.contains(name)) << name << " is missing in\n" << outcome.out;
    EXPECT_NEAR(found[name].estimated, value, 3.0 * found[name].sigma) << name;
    EXPECT_TRUE(found[name].is_determined) << name;
  }

  const std::string block = read_text(folder / "found.yaml");
  EXPECT_THAT(block, HasSubstr("sensors:\n  - name: wheels\n"));
  EXPECT_THAT(block, HasSubstr("    base_T_sensor:  # its other keys stay\n      yaw_deg: -"));
  // What the command proposes is a valid robot.
  std::vector<std::string> check{"check", replay};
  const std::size_t at = outcome.out.find("to try it: waymark run ");
  ASSERT_NE(at, std::string::npos) << outcome.out;
  const std::string proposal = outcome.out.substr(at, outcome.out.find('\n', at) - at);
  for (std::size_t begin = proposal.find(" --set '"); begin != std::string::npos;
       begin = proposal.find(" --set '", begin + 1)) {
    const std::size_t value = begin + std::string_view(" --set '").size();
    check.insert(check.end(), {"--set", proposal.substr(value, proposal.find('\'', value) - value)});
  }
  ASSERT_GT(check.size(), 12U) << proposal;
  const Outcome valid = waymark(check);
  EXPECT_EQ(valid.exit_code, 0) << valid.err;
}

// It drives 5 m and then stands; the noise of the simulated gyro is 3e-4 rad/√s.
TEST(Calibrate, ReadsTheNoiseOfTheGyroFromAStandingStretch) {
  const TemporaryFolder folder;
  write_text(folder / "robot.yaml", R"(
source:
  plugin: simulator
  seed: 3
  duration_s: 80
  course: { waypoints_m: [0, 0, 5, 0] }
  landmarks: { count: 0, area_m: [-5, -5, 10, 5], radius_m: [0.1, 0.2], seed: 1 }
  wheels: { sensor: wheels, track_m: 0.5 }
  imu: { sensor: imu, gyroscope_noise_radps_per_sqrt_hz: 3.0e-4, gyroscope_bias_sigma_radps: 0.002 }
initial: { x_m: 0, y_m: 0, yaw_deg: 0 }
sensors:
  - { name: wheels, plugin: odometry, model: differential, track_m: 0.5 }
  - { name: imu, plugin: imu, base_T_sensor: { yaw_deg: 0 } }
)");
  const Outcome outcome = waymark({"calibrate", (folder / "robot.yaml").string(), "--only",
                                   "imu.gyro_noise_rad_per_sqrt_s", "--json", (folder / "found.json").string()});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("imu stands from "));
  EXPECT_THAT(outcome.out, HasSubstr("# gyro bias at rest: ["));
  EXPECT_THAT(outcome.err, Not(HasSubstr("step 1:"))) << "nothing is adjusted";
  std::map<std::string, Found> found = read_found(folder / "found.json");
  const Found& noise = found["imu.gyro_noise_rad_per_sqrt_s"];
  EXPECT_NEAR(noise.estimated, 3e-4, 3.0 * noise.sigma);
  EXPECT_LT(noise.sigma, 0.25 * 3e-4);
  for (const char* axis : {"0", "1", "2"}) {
    const Found& bias = found[std::string("imu.gyro_bias_radps[") + axis + "]"];
    EXPECT_GT(bias.sigma, 0.0);
    EXPECT_LT(std::abs(bias.estimated), 4.0 * 0.002) << "of its distribution";
  }
}

TEST(Calibrate, AStandingImuOfARecording) {
  if (data_folder().empty()) GTEST_SKIP() << "WAYMARK_DATA is not set";
  const TemporaryFolder folder;
  const Outcome outcome =
      waymark({"calibrate", WAYMARK_SOURCE_DIR "/config/repoimu.yaml", "--set", "variables.trial=TStick_Test01_Static",
               "--only", "imu.gyro_noise_rad_per_sqrt_s", "--json", (folder / "found.json").string()});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  std::map<std::string, Found> found = read_found(folder / "found.json");
  // The mean rates of the whole log, by another program: 0.003671, -0.002329, 0.000983 rad/s; deviation · √τ at 1 s:
  // 6.5e-4, 6.2e-4, 5.9e-4.
  EXPECT_NEAR(found["imu.gyro_bias_radps[0]"].estimated, 0.003671, 5e-5);
  EXPECT_NEAR(found["imu.gyro_bias_radps[1]"].estimated, -0.002329, 5e-5);
  EXPECT_NEAR(found["imu.gyro_bias_radps[2]"].estimated, 0.000983, 5e-5);
  EXPECT_NEAR(found["imu.gyro_noise_rad_per_sqrt_s"].estimated, 6.2e-4, 0.3e-4);
}

// A constant field that turns with the robot is hard iron. The Earth's is 20 µT horizontally.
TEST(Calibrate, HardIronOfAMagnetometerOnARobotThatStaysLevel) {
  const TemporaryFolder folder;
  write_text(folder / "robot.yaml", R"(
source:
  plugin: simulator
  seed: 4
  duration_s: 120
  course: { waypoints_m: [0, 0, 8, 0, 8, 6, 0, 6], laps: 4 }
  landmarks: { count: 0, area_m: [-5, -5, 15, 10], radius_m: [0.1, 0.2], seed: 1 }
  magnetism: { disturbances_s: [0, 1000], disturbance_t: [6.0e-6, -3.0e-6, 4.0e-6], disturbance_frame: base }
  wheels: { sensor: wheels, track_m: 0.5 }
  gps: { sensor: gps, sigma_m: 0.05 }
  imu: { sensor: mag, rate_hz: 20 }
initial: { x_m: 0, y_m: 0, yaw_deg: 0 }
sensors:
  - { name: wheels, plugin: odometry, model: differential, track_m: 0.5 }
  - { name: gps, plugin: dgps, base_p_antenna_m: [0, 0, 0.5], sigma_m: 0.05, offset_sigma_m: 0 }
  - { name: mag, plugin: compass, declination: none, base_T_sensor: { yaw_deg: 90 } }
)");
  const std::string robot = (folder / "robot.yaml").string();
  const Outcome outcome =
      waymark({"calibrate", robot, "--json", (folder / "found.json").string(), "--only", "mag.hard_iron_t"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  std::map<std::string, Found> found = read_found(folder / "found.json");
  // The sensor's x axis is the base's y axis, its y axis the base's -x axis.
  const double truth[2] = {-3e-6, -6e-6};
  for (int axis : {0, 1}) {
    const Found& hard = found["mag.hard_iron_t[" + std::to_string(axis) + "]"];
    EXPECT_TRUE(hard.is_determined);
    EXPECT_NEAR(hard.estimated, truth[axis], 3.0 * hard.sigma) << axis;
    EXPECT_LT(hard.sigma, 1e-7) << axis;
  }
  EXPECT_FALSE(found["mag.hard_iron_t[2]"].is_determined) << "a level robot does not excite it";
  EXPECT_THAT(outcome.out, HasSubstr("    hard_iron_t: [-"));
  EXPECT_THAT(outcome.out, HasSubstr("up and down was not excited"));
  EXPECT_THAT(outcome.out, HasSubstr("--set 'sensors.mag.hard_iron_t=["));
}

TEST(Calibrate, AWrongSignIsNamedFirst) {
  const TemporaryFolder folder;
  const Outcome drive =
      waymark({"run", WAYMARK_SOURCE_DIR "/config/calibration.yaml", "--quiet", "--out", (folder / "drive").string(),
               "--set", "source.duration_s=150", "--set", "sinks=[{plugin: log}]"});
  ASSERT_EQ(drive.exit_code, 0) << drive.err;
  std::string replay = read_text(folder / "drive/log/replay.yaml");
  for (const auto& [from, to] : {std::pair<std::string, std::string>{"left_mps: left_mps", "left_mps: right_mps"},
                                 {"right_mps: right_mps", "right_mps: left_mps"}}) {
    const std::size_t at = replay.find(from);
    ASSERT_NE(at, std::string::npos) << replay;
    replay.replace(at, from.size(), to);
  }
  write_text(folder / "drive/log/swapped.yaml", replay);
  const Outcome outcome = waymark({"calibrate", (folder / "drive/log/swapped.yaml").string()});
  EXPECT_THAT(outcome.out, HasSubstr("source: swap left_mps and right_mps of wheels"));
  EXPECT_THAT(outcome.out, HasSubstr("# yaw: wheels: ")) << "in the block that is copied";
}

// Motion capture as odometry. The README of the recording: yaw -0.030 ± 0.006 rad, delay 34 ± 10 ms, x 7 mm, y 0.
TEST(Calibrate, MountingAndDelayOfAScannerFromItsOwnMotion) {
  if (data_folder().empty()) GTEST_SKIP() << "WAYMARK_DATA is not set";
  const TemporaryFolder folder;
  write_text(folder / "robot.yaml", R"(
variables:
  log: "${WAYMARK_DATA}/jackal_mocap_scan/2026-02-17-16-26-34"
source:
  plugin: csv
  files:
    - path: "${log}_scans.bin.gz"
      sensor: lidar
      payload: LaserScan
      records: { skip_bytes: 24, fields: [f8, f8, 897 u2] }
      time: { column: 0 }
      columns: { ranges_m: { first: 2, count: 897, scale: 1.0e-3 } }
      scan: { start_rad: -3.14159274, step_rad: 0.007 }
    - path: "${log}_mocap.csv.gz"
      sensor: mocap
      payload: PoseIncrement
      cumulative: true
      time: { column: t_s }
      columns: { x_m: x_m, y_m: y_m, q_w: qw, q_x: qx, q_y: qy, q_z: qz }
initial: { x_m: 0, y_m: 0, yaw_deg: 0 }
motion: { kind: planar }
sensors:
  - { name: mocap, plugin: odometry, model: increment, speed_noise_m_per_sqrt_s: [0.01, 0], lateral_noise_m_per_sqrt_s: [0.01, 0], yaw_noise_rad_per_sqrt_s: [0.01, 0, 0] }
  - { name: lidar, payload: LaserScan, base_T_sensor: { xyz_m: [0, 0, 0.3], yaw_deg: 0 } }
)");
  const Outcome outcome = waymark(
      {"calibrate", (folder / "robot.yaml").string(), "--only", "lidar", "--json", (folder / "found.json").string()});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  std::map<std::string, Found> found = read_found(folder / "found.json");
  const double yaw_sigma = std::hypot(found["lidar.base_T_sensor.yaw_deg"].sigma, 0.34);
  EXPECT_NEAR(found["lidar.base_T_sensor.yaw_deg"].estimated, -1.72, 2.0 * yaw_sigma);
  EXPECT_LT(yaw_sigma, 0.7);
  EXPECT_NEAR(found["lidar.delay_s"].estimated, 0.034, 0.010);
  EXPECT_LT(found["lidar.delay_s"].sigma, 0.008);
  EXPECT_NEAR(found["lidar.base_T_sensor.xyz_m[0]"].estimated, 0.007, 0.015);
  EXPECT_NEAR(found["lidar.base_T_sensor.xyz_m[1]"].estimated, 0.0, 0.015);
}

// The rates of wheels and gyro correlate best, by another program, with wheels 0.36 s late; its receiver wanders.
TEST(Calibrate, WheelsThatAreLateAmongOthers) {
  if (data_folder().empty()) GTEST_SKIP() << "WAYMARK_DATA is not set";
  const TemporaryFolder folder;
  const Outcome outcome = waymark({"calibrate", WAYMARK_SOURCE_DIR "/config/rl_husky.yaml", "--json",
                                   (folder / "found.json").string(), "--out", (folder / "found.yaml").string()});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  std::map<std::string, Found> found = read_found(folder / "found.json");
  EXPECT_NEAR(found["imu.delay_s"].estimated, -0.36, 0.03);
  EXPECT_NEAR(found["wheels.speed_scale"].estimated, 0.98, 0.03)
      << "by the best similarity of fixes and dead reckoning";
  EXPECT_FALSE(found["wheels.speed_noise_m_per_sqrt_s[0..1]"].is_determined);
  EXPECT_THAT(read_text(folder / "found.yaml"), HasSubstr("imu is ahead of it by so much"));
}

TEST(Calibrate, NeedsASpeed) {
  EXPECT_TRUE(reports_error(waymark({"calibrate", WAYMARK_SOURCE_DIR "/config/jackal.yaml"}), 1,
                            {"motion.source is maps", "a calibration needs wheels"}));
}

TEST(Calibrate, NamesWhatFitsNothing) {
  EXPECT_TRUE(reports_error(waymark({"calibrate", WAYMARK_SOURCE_DIR "/config/calibration.yaml", "--only", "sonar"}), 1,
                            {"--only sonar", "no parameter of this robot begins so"}));
}

}  // namespace
}  // namespace waymark::system_test
