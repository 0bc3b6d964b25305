// SPDX-License-Identifier: Apache-2.0
// needs plugins: csv, dgps, diagnostics, feature_map, held_out, landmarks, log, odometry, plot, simulator, tum
// What the sink `log` wrote is read back by the csv source, and the run that does it has the same results.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "tests/system/outputs.hpp"

namespace waymark::system_test {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Key;
using testing::Not;
using testing::SizeIs;

using Files = std::map<std::string, std::string>;

/// All that the simulator can deliver: at rates that give equal arrivals, with latencies, with noise everywhere.
constexpr const char* kRobot = R"(source:
  plugin: simulator
  seed: 5
  duration_s: 12
  course: { waypoints_m: [0, 0, 12, 0, 12, 8, 0, 8] }
  landmarks: { count: 16, area_m: [-5, -5, 17, 13], seed: 7, textures: 4, height_m: [2, 3] }
  wheels: { sensor: wheels, track_m: 0.5 }
  gps: { sensor: gps, rate_hz: 4, delay_s: 0.13, sigma_m: 0.3, correlated_sigma_m: 0.3, satellite_change_mean_s: 3 }
  lidar: { sensor: lidar, rate_hz: 5, range_max_m: 15 }
  camera: { sensor: camera, rate_hz: 5, delay_s: 0.06 }
  imu: { sensor: imu }
  compass: { sensor: compass }
initial: { yaw_deg: 0, yaw_sigma_deg: 2 }
sensors:
  - { name: wheels, plugin: odometry, model: differential, track_m: 0.5 }
  - { name: gps, plugin: dgps, base_p_antenna_m: [0, 0, 0.5], offset_sigma_m: 0.3, sigma_m: 0.3 }
  - { name: lidar, payload: LaserScan, base_T_sensor: { xyz_m: [0.2, 0, 0.3] } }
  - name: camera
    payload: Image
    base_T_sensor: { xyz_m: [0.2, 0, 0.5] }
    intrinsics: { size_px: [160, 120], focal_px: [140, 140], center_px: [80, 60] }
  - { name: imu, payload: ImuSample, base_T_sensor: { xyz_m: [0, 0, 0.1] } }
  - { name: compass, payload: CompassHeading, base_T_sensor: { xyz_m: [0, 0, 0.9] } }
maps:
  - name: pillars
    plugin: feature_map
    inputs: [lidar, camera]
    pair_max_age_s: 0.25
    attributes: [radius, signature]
    extraction: { range_min_m: 0.2, range_max_m: 14.5, no_return_m: 15.5 }
    existence: { view_range_m: 14, view_half_angle_deg: 130 }
filter: { particles: 5, seed: 1, max_latency_s: 0.2 }
sinks:
  - { plugin: tum }
  - { plugin: landmarks }
  - { plugin: diagnostics }
  - { plugin: log }
)";

class LogReplay : public ::testing::Test {
 protected:
  LogReplay() { write_text(folder_ / "robot.yaml", kRobot); }

  std::filesystem::path log() const { return folder_ / "first" / "log"; }

  /// Outputs of a run; the source in config.yaml is another one.
  Files run(const std::filesystem::path& config, std::string_view out, std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"run", config.string(), "--out", (folder_ / out).string(), "--quiet"});
    const Outcome outcome = waymark(std::move(more));
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return contents(folder_ / out, {"config.yaml", "log"});
  }
  Files first_run(std::vector<std::string> more = {}) const {
    return run(folder_ / "robot.yaml", "first", std::move(more));
  }
  Files replay() const { return run(log() / "replay.yaml", "second"); }

  /// How many measurements of a sensor had a fate.
  static int count(const Files& files, std::string_view sensor, const char* fate) {
    const auto all = nlohmann::json::parse(files.at("diagnostics.json")).at("sensors");
    for (const auto& one : all) {
      if (one.at("name") == sensor) return one.at(fate).get<int>();
    }
    return -1;
  }

  TemporaryFolder folder_;
};

TEST_F(LogReplay, AllSixSensorsGiveTheSameBytes) {
  const Files first = first_run();
  for (const char* name : {"trajectory.txt", "landmarks.csv", "covariance.csv", "path.txt", "diagnostics.json"})
    EXPECT_THAT(first, Contains(Key(name)));
  // The run was one in which every sensor was fused.
  EXPECT_GT(count(first, "gps", "fused"), 20);
  EXPECT_EQ(count(first, "lidar", "mapped"), 60);
  EXPECT_EQ(count(first, "camera", "mapped"), 60);
  EXPECT_GT(count(first, "imu", "ignored"), 1000);
  EXPECT_GT(count(first, "compass", "ignored"), 100);
  EXPECT_THAT(first.at("diagnostics.json"), Not(HasSubstr("\"images_used\": 0.0")));
  EXPECT_TRUE(has_no_partial_file(log()));

  EXPECT_TRUE(same_bytes(first, replay()));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "second" / "log")) << "a replay writes no log of a log";
}

TEST_F(LogReplay, WhatCameTooLateComesTooLateAgain) {
  const Files first = first_run({"--set", "filter.max_latency_s=0.05", "--set", "filter.history_s=0", "--set",
                                 "initial.x_m=0", "--set", "initial.y_m=0"});
  EXPECT_EQ(count(first, "gps", "late"), 48);
  EXPECT_GT(count(first, "camera", "late"), 0);
  EXPECT_THAT(lines_of(read_text(log() / "gps.csv")), SizeIs(1 + 48));
  EXPECT_TRUE(same_bytes(first, replay()));
}

TEST_F(LogReplay, WhatIsTakenInLateIsTakenInLateAgain) {
  const Files first =
      first_run({"--set", "filter.max_latency_s=0.05", "--set", "initial.x_m=0", "--set", "initial.y_m=0"});
  EXPECT_EQ(count(first, "gps", "late"), 0);
  EXPECT_GT(count(first, "gps", "processed_late"), 20);
  EXPECT_TRUE(same_bytes(first, replay()));
}

TEST_F(LogReplay, WhatTheFilterDoesNotSeeIsInTheLogToo) {
  const Files first = first_run({"--set", "sensors.gps.fuse=start"});
  EXPECT_GT(count(first, "gps", "held_out"), 20);
  EXPECT_TRUE(same_bytes(first, replay()));
}

TEST_F(LogReplay, ASensorThatIsSwitchedOffIsNotInTheLog) {
  const Files first = first_run({"--set", "sensors.camera.enabled=false", "--set", "sensors.imu.enabled=false"});
  EXPECT_FALSE(std::filesystem::exists(log() / "imu.csv"));
  EXPECT_FALSE(std::filesystem::exists(log() / "camera"));
  EXPECT_TRUE(same_bytes(first, replay()));
}

TEST_F(LogReplay, TheLogMayBeCarriedElsewhere) {
  const Files first = first_run();
  std::filesystem::rename(folder_ / "first", folder_ / "elsewhere");
  EXPECT_TRUE(same_bytes(first, run(folder_ / "elsewhere" / "log" / "replay.yaml", "second")));
}

TEST_F(LogReplay, TheShippedRobotGivesTheSameBytes) {
  const Files first =
      run(WAYMARK_SOURCE_DIR "/config/quickstart.yaml", "first",
          {"--set", "source.duration_s=20", "--set", "sinks=[plugin: tum, plugin: landmarks, plugin: log]"});
  EXPECT_TRUE(same_bytes(first, replay()));
}

TEST_F(LogReplay, RecordingsGiveTheSameBytes) {
  if (data_folder().empty()) GTEST_SKIP() << "WAYMARK_DATA is not set";
  for (const std::string name : {"acfr_car_park", "utias_mrclam"}) {
    const Files first = run(WAYMARK_SOURCE_DIR "/config/" + name + ".yaml", "first",
                            {"--set", "filter.particles=3", "--set",
                             "sinks=[plugin: tum, plugin: landmarks, plugin: diagnostics, plugin: log]"});
    EXPECT_TRUE(same_bytes(first, replay())) << name;
    std::filesystem::remove_all(folder_ / "first");
    std::filesystem::remove_all(folder_ / "second");
  }
}

TEST_F(LogReplay, AnInterruptedRunLeavesAWholeLog) {
  const std::filesystem::path scans = log() / "lidar.csv.partial";
  const Outcome outcome =
      Command({"run", (folder_ / "robot.yaml").string(), "--out", (folder_ / "first").string(), "--quiet", "--set",
               "source.duration_s=1800", "--set", "sensors.camera.enabled=false"})
          .send(SIGINT,
                [&] {
                  std::error_code error;
                  const auto size = std::filesystem::file_size(scans, error);
                  return !error && size > 100'000;
                })
          .run();
  EXPECT_EQ(outcome.exit_code, 130) << outcome.err;
  EXPECT_TRUE(has_no_partial_file(log()));
  // Only the note that the run was interrupted is another.
  // The last two say that the run was interrupted.
  const std::set<std::string> left_out{"config.yaml", "log", "diagnostics.json", "report.html"};
  Files second = replay();
  second.erase("diagnostics.json");
  second.erase("report.html");
  EXPECT_TRUE(same_bytes(contents(folder_ / "first", left_out), second));
}

TEST_F(LogReplay, ASensorThatSaysNothingIsSwitchedOff) {
  // A scanner that first speaks after the end.
  first_run({"--set", "source.lidar.rate_hz=0.001", "--set", "sensors.camera.enabled=false"});
  EXPECT_FALSE(std::filesystem::exists(log() / "lidar.csv"));
  replay();
}

TEST_F(LogReplay, AFullDiskIsOneLineAndKeepsWhatFits) {
  // A file may grow to 200 kB; the IMU's needs more.
  const Outcome outcome =
      Command({"run", (folder_ / "robot.yaml").string(), "--out", (folder_ / "first").string(), "--quiet"})
          .in_child([] {
            ::signal(SIGXFSZ, SIG_IGN);
            const rlimit limit{200'000, 200'000};
            ::setrlimit(RLIMIT_FSIZE, &limit);
          })
          .run();
  EXPECT_TRUE(reports_error(outcome, 3, {"sink log: taken out of service", "log/", "File too large"}));
  EXPECT_TRUE(has_complete_lines(folder_ / "first" / "trajectory.txt", 100)) << "the other outputs are whole";
  for (const char* name : {"wheels.csv", "gps.csv", "lidar.csv", "imu.csv"}) {
    EXPECT_TRUE(has_complete_lines(log() / name, 10));
  }
  EXPECT_TRUE(has_no_partial_file(log()));
  run(log() / "replay.yaml", "second");
}

}  // namespace
}  // namespace waymark::system_test
