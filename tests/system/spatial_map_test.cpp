// SPDX-License-Identifier: Apache-2.0
// needs plugins: clouds, csv, diagnostics, grid_map, imu, map_files, octomap_grid, odometry, plot, simulator, tum
// A dense map that is matched in six degrees of freedom: up a ramp, and a scanner that is carried by hand.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "tests/system/outputs.hpp"

namespace waymark::system_test {
namespace {

nlohmann::json scored(const std::filesystem::path& out, const std::vector<std::string>& options = {}) {
  std::vector<std::string> arguments{"evaluate", out.string(), "--json"};
  arguments.insert(arguments.end(), options.begin(), options.end());
  const Outcome outcome = Command(std::move(arguments)).run();
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  return nlohmann::json::parse(outcome.out);
}

Outcome ramp(const std::filesystem::path& out, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {"run", WAYMARK_SOURCE_DIR "/config/ramp_3d.yaml", "--quiet", "--set",
                                       "sinks.plot.enabled=false", "--out", out.string()});
  return Command(std::move(arguments)).timeout(std::chrono::seconds(500)).run();
}

TEST(SpatialMap, TheRobotFindsItsHeightOnTheRampAndOnTheUpperFloor) {
  const TemporaryFolder folder;
  const std::filesystem::path out = folder / "out";
  const Outcome outcome = ramp(out, {"--set", "filter.particles=5"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const nlohmann::json score = scored(out);
  // docs/results/ramp_3d.md.
  EXPECT_LE(score.at("trajectory").at("ate_rms_m").get<double>(), 0.15) << score.dump();
  EXPECT_EQ(score.at("consistency_of_six").at("nees_dimensions"), 6);
  EXPECT_EQ(read_text(out / "covariance.csv").substr(0, 46), "t_s,xx,xy,xyaw,yy,yyaw,yawyaw,xz,yz,yawz,zz,xr");
}

TEST(SpatialMap, AResumedRunEndsAsTheWholeOne) {
  const TemporaryFolder folder;
  const std::vector<std::string> few{"--set", "filter.particles=3"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.end(), few.begin(), few.end());
    return more;
  };
  const std::string saved = (folder / "state").string();
  ASSERT_EQ(ramp(folder / "whole", with({"--until", "8"})).exit_code, 0);
  ASSERT_EQ(ramp(folder / "first", with({"--until", "5", "--save", saved})).exit_code, 0);
  const Outcome resumed = ramp(folder / "second", with({"--until", "8", "--resume", saved}));
  ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
  EXPECT_EQ(read_text(folder / "whole/path.txt"), read_text(folder / "second/path.txt"));
  EXPECT_EQ(read_text(folder / "whole/hall.bt"), read_text(folder / "second/hall.bt"));
}

TEST(SpatialMap, AMapThatMatchesAllSixNeedsSpatialMotion) {
  const TemporaryFolder folder;
  const Outcome outcome = ramp(folder / "out", {"--set", "motion.kind=planar", "--set", "sensors.imu.tilt=false"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, testing::HasSubstr("motion.kind: planar holds height, roll and pitch, which the map "
                                              "\"hall\" matches"));
}

TEST(SpatialMap, AHeightThatNothingObservesIsReported) {
  const TemporaryFolder folder;
  const std::filesystem::path out = folder / "out";
  const Outcome outcome = ramp(out, {"--until", "15", "--set", "sensors.wheels.vertical_noise_m_per_sqrt_s=none",
                                     "--set", "maps=[]", "--set", "filter.particles=1"});
  EXPECT_THAT(outcome.err, testing::HasSubstr("nothing observes the height"));
  const nlohmann::json diagnostics = nlohmann::json::parse(read_text(out / "diagnostics.json"));
  EXPECT_GT(diagnostics.at("health").at("degraded_s").get<double>(), 8.0) << diagnostics.at("health").dump();
  EXPECT_THAT(diagnostics.at("health").dump(), testing::HasSubstr("the height is too uncertain"));
}

TEST(SpatialMap, AScannerThatIsCarriedByHandIsTrackedAlone) {
  if (data_folder().empty()) GTEST_SKIP() << "WAYMARK_DATA is not set";
  const TemporaryFolder folder;
  const std::filesystem::path out = folder / "out";
  const Outcome outcome =
      Command({"run", WAYMARK_SOURCE_DIR "/config/hilti.yaml", "--quiet", "--out", out.string()}).run();
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const nlohmann::json score = scored(out, {"--align", "se3"});
  // docs/results/hilti.md: 0.04 m.
  EXPECT_LE(score.at("trajectory").at("ate_rms_m").get<double>(), 0.08) << score.dump();
}

TEST(SpatialMap, BesideAnImuTheScansShowHowTheRobotMoves) {
  const TemporaryFolder folder;
  const std::filesystem::path out = folder / "out";
  const Outcome outcome = Command({"run", WAYMARK_SOURCE_DIR "/config/lidar_imu_3d.yaml", "--quiet", "--out",
                                   out.string(), "--until", "30", "--set", "filter.particles=1"})
                              .timeout(std::chrono::seconds(500))
                              .run();
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const nlohmann::json score = scored(out);
  EXPECT_LE(score.at("trajectory").at("ate_rms_m").get<double>(), 0.15) << score.dump();
}

TEST(PlanarMap, BesideAnImuTheScansShowHowTheRobotMoves) {
  const TemporaryFolder folder;
  std::string yaml = read_text(WAYMARK_SOURCE_DIR "/config/indoor.yaml");
  const auto replace = [&](const std::string& from, const std::string& to, const std::string& text) {
    const std::size_t begin = yaml.find(from);
    const std::size_t end = yaml.find(to, begin);
    ASSERT_NE(end, std::string::npos) << from;
    yaml.replace(begin, end - begin, text);
  };
  replace("  wheels: {", "  lidar: {", "  imu: { sensor: imu, rate_hz: 50, magnetometer: false }\n");
  replace("  - name: wheels", "  - name: lidar",
          "  - { name: imu, plugin: imu, base_T_sensor: { xyz_m: [0, 0, 0.1] } }\n");
  replace("initial:", "motion:", "initial: { x_m: 0, y_m: 0, yaw_deg: 0, speed_sigma_mps: 0.1 }\n\n");
  write_text(folder / "robot.yaml", yaml);
  const std::filesystem::path out = folder / "out";
  // Beams of their own times, too: what only the scans show must not feed back through their motion compensation.
  for (const char* sweep_s : {"0", "0.095"}) {
    const Outcome outcome =
        Command({"run", (folder / "robot.yaml").string(), "--quiet", "--out", out.string(), "--set",
                 "source.lidar.rate_hz=10", "--set", std::string("source.lidar.sweep_s=") + sweep_s})
            .run();
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    const nlohmann::json score = scored(out);
    EXPECT_LE(score.at("trajectory").at("ate_rms_m").get<double>(), 0.15) << sweep_s << ' ' << score.dump();
  }
}

}  // namespace
}  // namespace waymark::system_test
