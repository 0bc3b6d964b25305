// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/import/robot_localization.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "temporary_folder.hpp"
#include "waymark/base/error.hpp"

namespace waymark::imports {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kTwist =
    "[false, false, false, false, false, false, true, true, false, false, false, true, false, false, false]";
constexpr const char* kPosition =
    "[true, true, false, false, false, false, false, false, false, false, false, false, false, false, false]";
constexpr const char* kRates =
    "[false, false, false, false, false, true, false, false, false, false, false, true, true, false, false]";

/// What is made of a file with this text.
class ImportOfRobotLocalization : public ::testing::Test {
 protected:
  Imported import_text(const std::string& text, const ImportSettings& settings = {}) const {
    std::ofstream(file_) << text;
    return import_robot_localization(file_, settings);
  }
  std::string error_of(const std::string& text, const ImportSettings& settings = {}) const {
    try {
      import_text(text, settings);
    } catch (const DataError& error) {
      return error.what();
    }
    return "no error";
  }

 private:
  test::TemporaryFolder folder_;
  std::filesystem::path file_ = folder_.path() / "ekf.yaml";
};

std::string wheels_and_imu() {
  return fmt::format("two_d_mode: true\nodom0: wheel/odometry\nodom0_config: {}\nimu0: /imu/data\nimu0_config: {}\n",
                     kTwist, kRates);
}

TEST_F(ImportOfRobotLocalization, TakesTopicsOfWheelsAndImu) {
  const std::string yaml = import_text(wheels_and_imu()).yaml;
  EXPECT_THAT(yaml, HasSubstr("{ topic: /wheel/odometry, type: nav_msgs/msg/Odometry, sensor: odom0 }"));
  EXPECT_THAT(yaml, HasSubstr("{ topic: /imu/data, type: sensor_msgs/msg/Imu, sensor: imu0 }"));
  EXPECT_THAT(yaml, HasSubstr("{ name: odom0, plugin: odometry, model: twist }"));
  EXPECT_THAT(yaml, HasSubstr("{ name: imu0, plugin: imu, base_T_sensor: from_tf }"));
  EXPECT_THAT(yaml, HasSubstr("kind: planar"));
}

TEST_F(ImportOfRobotLocalization, ReadsTheFormOfRos2) {
  std::string text = "ekf_filter_node:\n  ros__parameters:\n";
  text += fmt::format("    odom0: /odom\n    odom0_config: {}\n", kTwist);
  EXPECT_THAT(import_text(text).yaml, HasSubstr("kind: spatial"));
}

TEST_F(ImportOfRobotLocalization, ReplacesTheOutputOfNavsatTransformByTheFixes) {
  const std::string text = wheels_and_imu() + fmt::format("odom1: /odometry/gps\nodom1_config: {}\n", kPosition);
  const std::string yaml = import_text(text, {.node = "", .recording = {}, .fix_topic = "/gnss/fix"}).yaml;
  EXPECT_THAT(yaml, HasSubstr("{ topic: /gnss/fix, type: sensor_msgs/msg/NavSatFix, sensor: gps }"));
  EXPECT_THAT(yaml, HasSubstr("plugin: dgps"));
  EXPECT_THAT(yaml, Not(HasSubstr("initial:")));
}

TEST_F(ImportOfRobotLocalization, TakesPosesOfAnOdometryAsIncrements) {
  const std::string yaml = import_text(fmt::format("odom0: /vo\nodom0_config: {}\n", kPosition)).yaml;
  EXPECT_THAT(yaml, HasSubstr("payload: PoseIncrement"));
  EXPECT_THAT(yaml, HasSubstr("model: increment"));
}

TEST_F(ImportOfRobotLocalization, ReportsWhatItCannotTakeOver) {
  const std::string text = wheels_and_imu() + fmt::format("pose0: /amcl_pose\npose0_config: {}\n", kPosition);
  const Imported imported = import_text(text);
  EXPECT_THAT(imported.notes, Contains(HasSubstr("pose0 (/amcl_pose): absolute poses are not an input")));
  EXPECT_THAT(imported.yaml, HasSubstr("# - pose0 (/amcl_pose)"));
  EXPECT_THAT(imported.yaml, Not(HasSubstr("topic: /amcl_pose")));
}

TEST_F(ImportOfRobotLocalization, ConvertsVariancesPerSecondToNoiseDensities) {
  const std::string Q =
      "process_noise_covariance: [0.05, 0.05, 0.06, 0.03, 0.03, 0.06, 0.25, 0.04, 0.09, 0.01, 0.01, 0.16, 0.01, 0.01, "
      "0.015]\n";
  const std::string yaml = import_text(wheels_and_imu() + Q).yaml;
  EXPECT_THAT(yaml, HasSubstr("velocity_noise_mps_per_sqrt_s: [0.5, 0.2, 0.3]"));
  EXPECT_THAT(yaml, HasSubstr("rate_noise_radps_per_sqrt_s: [0.1, 0.1, 0.4]"));
}

TEST_F(ImportOfRobotLocalization, ReadsARecordingInsteadOfARunningRobot) {
  const Imported imported = import_text(wheels_and_imu(), {.node = "", .recording = "/data/drive.bag"});
  EXPECT_THAT(imported.yaml, HasSubstr("plugin: rosbag1\n  file: \"/data/drive.bag\""));
  EXPECT_THAT(imported.yaml, HasSubstr("{ topic: /imu/data, sensor: imu0 }"));
  EXPECT_THAT(imported.yaml, Not(HasSubstr("from_tf")));
  EXPECT_THAT(imported.notes, Contains(HasSubstr("set its base_T_sensor")));
}

TEST_F(ImportOfRobotLocalization, ChoosesTheFilterOfTheMapOfTwo) {
  const auto filter = [](const char* name, const char* world, const char* topic) {
    return fmt::format(
        "{}:\n  ros__parameters:\n    map_frame: map\n    odom_frame: odom\n    world_frame: {}\n"
        "    odom0: {}\n    odom0_config: {}\n",
        name, world, topic, kTwist);
  };
  const std::string text = filter("local", "odom", "/a") + filter("global", "map", "/b");
  const Imported imported = import_text(text);
  EXPECT_THAT(imported.yaml, HasSubstr("topic: /b"));
  EXPECT_THAT(imported.notes, Contains(HasSubstr("this is global")));
  EXPECT_THAT(import_text(text, {.node = "local"}).yaml, HasSubstr("topic: /a"));
  EXPECT_THAT(error_of(text, {.node = "other"}), HasSubstr("there is no filter \"other\"; there are: global, local"));
}

TEST_F(ImportOfRobotLocalization, NamesThePlaceOfAWrongValue) {
  EXPECT_THAT(error_of("odom0: /odom\nodom0_config: [true, false]\n"),
              HasSubstr("ekf.yaml:2: odom0_config has 2 entries; 15 are expected"));
  EXPECT_THAT(error_of("odom0: /odom\nodom0_config: [yes please]\n"), HasSubstr("ekf.yaml:2: odom0_config: a list of"));
  EXPECT_THAT(error_of("odom0: /odom\n"), HasSubstr("ekf.yaml:1: odom0_config is missing"));
  EXPECT_THAT(error_of("slam: 1\n"), HasSubstr("there is no filter of robot_localization in it"));
  EXPECT_THAT(error_of("a: [\n"), HasSubstr("ekf.yaml:"));
}

TEST_F(ImportOfRobotLocalization, NeedsAnInputThatMeasuresMotion) {
  EXPECT_THAT(error_of(fmt::format("odom0: /odometry/gps\nodom0_config: {}\n", kPosition)),
              HasSubstr("no input measures how the robot moves"));
}

}  // namespace
}  // namespace waymark::imports
