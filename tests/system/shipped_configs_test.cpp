// SPDX-License-Identifier: Apache-2.0
// needs plugins: altimeter, carmen, compass, csv, dgps, diagnostics, feature_map, grid_map, held_out, imu, json
// needs plugins: json_poses, kitti, landmarks, map_files, nmea, occupancy_grid, octomap_grid, odometry, plot, rosbag1
// needs plugins: clouds, simulator, tum
//
// Every YAML in config/ is valid, runs, and its effective configuration holds all that it takes to run again.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tests/system/outputs.hpp"

namespace waymark::system_test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

std::vector<std::string> shipped() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(WAYMARK_SOURCE_DIR "/config")) {
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

class ShippedConfig : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (read_text(file()).find("${WAYMARK_DATA}") != std::string::npos && data_folder().empty())
      GTEST_SKIP() << "WAYMARK_DATA is not set";
  }
  static std::string file() { return std::string(WAYMARK_SOURCE_DIR "/config/") + GetParam() + ".yaml"; }
  static bool is_live() { return GetParam().starts_with("live_"); }
  static bool has_map() { return read_text(file()).find("\nmaps:") != std::string::npos; }
  static bool has_grid() {
    const std::string text = read_text(file());
    return text.find("plugin: occupancy_grid") != std::string::npos ||
           text.find("plugin: octomap_grid") != std::string::npos;
  }
  /// What is run of a configuration that takes long.
  static std::vector<std::string> short_of() {
    if (GetParam() == "figure_2_1") return {"--until", "20"};
    if (GetParam() == "paper" || GetParam() == "paper_literal") return {"--until", "40"};
    const bool has_clouds = GetParam() == "simulated_3d" || GetParam() == "ramp_3d" || GetParam() == "uneven_3d" ||
                            GetParam() == "lidar_imu_3d";
    if (has_clouds) return {"--until", "10"};
    if (GetParam() == "hilti") return {"--set", "sources.0.last_cloud=20"};
    return {};
  }
  static Outcome run(const std::filesystem::path& config, const std::filesystem::path& out) {
    std::vector<std::string> arguments{"run", config.string(), "--out", out.string()};
    for (const std::string& one : short_of()) arguments.push_back(one);
    return Command(arguments).timeout(std::chrono::seconds(600)).run();
  }
  TemporaryFolder folder_;
};

TEST_P(ShippedConfig, IsValid) {
  const Outcome outcome = Command({"check", file()}).run();
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr(file() + ": valid\n"));
  EXPECT_THAT(outcome.err, IsEmpty());
  if (GetParam() == "live_ros2") {
    EXPECT_THAT(outcome.out, HasSubstr("mounted where the robot reports it (from_tf)"));
    EXPECT_THAT(outcome.out, HasSubstr("base_T_sensor: from_tf"));
  }
}

TEST_P(ShippedConfig, RunsAndItsEffectiveConfigurationGivesTheSameBytes) {
  if (is_live()) GTEST_SKIP() << "a running robot does not end by itself: see live_json_test.cpp, ros2_test.cpp";
  const std::filesystem::path out = folder_ / "out";
  const Outcome outcome = run(file(), out);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.errors(), IsEmpty()) << outcome.err;
  for (const char* name : {"trajectory.txt", "path.txt"}) EXPECT_TRUE(has_complete_lines(out / name, 5));
  EXPECT_TRUE(nlohmann::json::accept(read_text(out / "diagnostics.json")));
  if (has_map()) {
    if (!has_grid()) {
      EXPECT_TRUE(has_complete_lines(out / "landmarks.csv", 5));
    }
    EXPECT_THAT(read_text(out / "map.png"), HasSubstr("PNG"));
  }
  EXPECT_THAT(read_text(out / "config.yaml"), Not(HasSubstr("${")))
      << "an effective configuration has no variables left";
  EXPECT_TRUE(has_no_partial_file(out));

  const std::filesystem::path again = folder_ / "again";
  // By the same name, which pictures have as their title.
  const std::filesystem::path effective = out / (std::string(GetParam()) + ".yaml");
  std::filesystem::copy_file(out / "config.yaml", effective);
  const Outcome repeated = run(effective, again);
  ASSERT_EQ(repeated.exit_code, 0) << repeated.err;
  // The second config.yaml no longer marks which values are defaults.
  EXPECT_TRUE(
      same_bytes(contents(out, {"config.yaml", effective.filename().string()}), contents(again, {"config.yaml"})));
}

INSTANTIATE_TEST_SUITE_P(Config, ShippedConfig, testing::ValuesIn(shipped()),
                         [](const auto& config) { return config.param; });

TEST(CarPark, StaysWithinItsErrorAgainstHeldOutFixes) {
  if (data_folder().empty()) GTEST_SKIP() << "WAYMARK_DATA is not set";
  const TemporaryFolder folder;
  const std::filesystem::path out = folder / "out";
  const Outcome run = waymark(
      {"run", WAYMARK_SOURCE_DIR "/config/acfr_car_park.yaml", "--out", out.string(), "--quiet", "--seed", "1"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Outcome score =
      waymark({"evaluate", "--estimate", (out / "trajectory.txt").string(), "--reference",
               (out / "held_out.csv").string(), "--align", "se2", "--lever-arm", "3.78,0.5,0", "--json"});
  ASSERT_EQ(score.exit_code, 0) << score.err;
  const nlohmann::json report = nlohmann::json::parse(score.out);
  EXPECT_GT(report.at("trajectory").at("scored").get<int>(), 500) << score.out;
  EXPECT_EQ(report.at("trajectory").at("alignment"), "se2");
  EXPECT_LE(report.at("trajectory").at("ate_rms_m").get<double>(), 0.20) << score.out;
}

TEST(LegoCylinders, LandmarksAndGridFindTheSixCylindersOnceEach) {
  if (data_folder().empty()) GTEST_SKIP() << "WAYMARK_DATA is not set";
  for (const char* seed : {"1", "2", "3"}) {
    const TemporaryFolder folder;
    const std::filesystem::path out = folder / "out";
    const Outcome run = waymark(
        {"run", WAYMARK_SOURCE_DIR "/config/lego_cylinders.yaml", "--out", out.string(), "--quiet", "--seed", seed});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const Outcome score =
        waymark({"evaluate", "--estimate", (out / "trajectory.txt").string(), "--reference",
                 (out / "reference.txt").string(), "--align", "se2", "--landmarks", (out / "landmarks.csv").string(),
                 "--survey", (out / "reference_landmarks.csv").string(), "--match-radius-m", "0.3", "--json"});
    ASSERT_EQ(score.exit_code, 0) << score.err;
    const nlohmann::json report = nlohmann::json::parse(score.out);
    EXPECT_GT(report.at("trajectory").at("scored").get<int>(), 270) << score.out;
    // docs/results/hybrid.md: 0.07 m and 0.05 m.
    EXPECT_LE(report.at("trajectory").at("ate_rms_m").get<double>(), 0.12) << score.out;
    EXPECT_EQ(report.at("landmarks").at("matched"), 6) << score.out;
    EXPECT_EQ(report.at("landmarks").at("duplicates"), 0) << score.out;
    EXPECT_EQ(report.at("landmarks").at("others"), 0) << score.out;
    EXPECT_LE(report.at("landmarks").at("landmark_rms_m").get<double>(), 0.1) << score.out;
  }
}

TEST(Jackal, OneScannerIsAsGoodAsMotionCaptureSays) {
  if (data_folder().empty()) GTEST_SKIP() << "WAYMARK_DATA is not set";
  for (const char* recording : {"2026-02-17-15-00-16", "2026-02-17-15-18-31", "2026-02-17-16-26-34"}) {
    const TemporaryFolder folder;
    const std::filesystem::path out = folder / "out";
    const Outcome run = waymark({"run", WAYMARK_SOURCE_DIR "/config/jackal.yaml", "--out", out.string(), "--quiet",
                                 "--set", std::string("variables.recording=") + recording});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const Outcome score = waymark({"evaluate", out.string(), "--align", "se2", "--json"});
    ASSERT_EQ(score.exit_code, 0) << score.err;
    const nlohmann::json report = nlohmann::json::parse(score.out);
    EXPECT_GT(report.at("trajectory").at("scored").get<int>(), 2000) << score.out;
    // docs/results/jackal.md: 0.038 m at most, over ten seeds of each.
    EXPECT_LE(report.at("trajectory").at("ate_rms_m").get<double>(), 0.06) << recording << "\n" << score.out;
  }
}

/// Runs a configuration and gives the RMS error of its held-out fixes in the plane [m].
double error_in_plane(const std::string& name, const std::vector<std::string>& overrides, const std::string& datum,
                      const std::string& align) {
  const TemporaryFolder folder;
  const std::filesystem::path out = folder / "out";
  std::vector<std::string> arguments{"run", std::string(WAYMARK_SOURCE_DIR "/config/") + name, "--out", out.string(),
                                     "--quiet"};
  for (const std::string& text : overrides) arguments.insert(arguments.end(), {"--set", text});
  const Outcome run = waymark(arguments);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const Outcome score = waymark({"evaluate", "--estimate", (out / "trajectory.txt").string(), "--reference",
                                 (out / "held_out.csv").string(), "--align", align, "--datum", datum, "--json"});
  EXPECT_EQ(score.exit_code, 0) << score.err;
  const nlohmann::json trajectory = nlohmann::json::parse(score.out).at("trajectory");
  return trajectory.at(align == "none" ? "ate_horizontal_rms_m" : "ate_rms_m").get<double>();
}

TEST(Husky, DeadReckoningIsAsGoodAsTheDataSetSays) {
  if (data_folder().empty()) GTEST_SKIP() << "WAYMARK_DATA is not set";
  const std::string datum = "42.375812,-71.14739467,7.3";
  // 3.0 m after the best fit in the plane: its README. GPS is not better known than that.
  EXPECT_LE(error_in_plane("rl_husky.yaml", {"variables.gps=start"}, datum, "se2"), 3.1);
  const double late = error_in_plane("rl_husky.yaml", {}, datum, "none");
  EXPECT_LE(late, 2.0);
  const double in_time = error_in_plane("rl_husky.yaml", {"source.arrival=stamp"}, datum, "none");
  EXPECT_NEAR(late, in_time, 0.02 * in_time) << "the IMU is up to 36 ms late, max_latency_s covers that";
}

TEST(KittiExcerpt, TrunksAndMastsAreTrackedThroughAllFrames) {
  if (data_folder().empty()) GTEST_SKIP() << "WAYMARK_DATA is not set";
  const TemporaryFolder folder;
  const std::filesystem::path out = folder / "out";
  const Outcome run = waymark({"run", WAYMARK_SOURCE_DIR "/config/kitti_raw.yaml", "--out", out.string(), "--quiet"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json report = nlohmann::json::parse(read_text(out / "diagnostics.json"));
  EXPECT_EQ(report.at("landmarks").at(0).at("figures").at("images_used").get<int>(), 20);
  EXPECT_EQ(report.at("run").at("bad_record_count").get<int>(), 0);
  // docs/results/kitti.md: seven things are seen in all scans, and the car rolls 4.4 m straight on.
  int in_all = 0;
  for (const std::string& line : lines_of(read_text(out / "landmarks.csv"))) {
    std::vector<std::string> fields;
    std::istringstream in(line);
    for (std::string field; std::getline(in, field, ',');) fields.push_back(field);
    in_all += fields.at(10) == "20" ? 1 : 0;
  }
  EXPECT_GE(in_all, 6);
  std::istringstream last(lines_of(read_text(out / "trajectory.txt")).back());
  double t = 0.0;
  double x = 0.0;
  double y = 0.0;
  last >> t >> x >> y;
  EXPECT_NEAR(x, 4.4, 0.15);
  EXPECT_NEAR(y, 0.0, 0.15);
}

}  // namespace
}  // namespace waymark::system_test
