// SPDX-License-Identifier: Apache-2.0
// needs plugins: odometry, dgps, simulator
#include "waymark/host/robot.hpp"

#include <gmock/gmock.h>

#include <memory>
#include <string>

#include "waymark/base/error.hpp"

namespace waymark::host {
namespace {

using testing::EndsWith;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;
using testing::ThrowsMessage;
using testing::UnorderedElementsAre;

const std::string kWheels = "{ name: wheels, plugin: odometry, model: twist }";
const std::string kTicks = "{ name: wheels, plugin: odometry, model: differential, track_m: 0.5 }";
const std::string kGps = "{ name: gps, plugin: dgps, base_p_antenna_m: [0, 0, 0], sigma_m: 1, enabled: false }";
const std::string kSource =
    "source: { plugin: simulator, duration_s: 2, speed_mps: 1, course: { waypoints_m: [0, 0, 9, 0] }, "
    "wheels: { sensor: wheels, rate_hz: 10, track_m: 0.5 }, gps: { sensor: gps, rate_hz: 1, base_p_antenna_m: [0, 0, "
    "0], sigma_m: 0.3 } }, ";

Config yaml(const std::string& text) { return Config::parse("{ " + text + " }", "robot.yaml"); }
PluginLoader loader() { return PluginLoader({WAYMARK_PLUGIN_DIR}); }

TEST(Robot, AssignsEveryMeasurementOfItsSourceToASensorThatIsSwitchedOn) {
  const Robot robot = Robot::load(yaml(kSource + "sensors: [" + kGps + ", " + kTicks + "]"), loader());
  int assigned = 0;
  int off = 0;
  while (auto measurement = robot.source->next()) {
    const std::string sensor = robot.source->channels()[measurement->sensor].sensor;
    if (robot.assign(*measurement)) {
      ++assigned;
      EXPECT_EQ(sensor, "wheels");
      EXPECT_EQ(measurement->sensor, 1u);
    } else {
      ++off;
      EXPECT_EQ(sensor, "gps");
    }
  }
  EXPECT_GT(assigned, 10);
  EXPECT_GT(off, 0);
}

TEST(Robot, NeedsASourceUnlessTheProgramDeliversTheMeasurements) {
  const std::string sensors = "sensors: [" + kWheels + "]";
  EXPECT_THROW(Robot::load(yaml(sensors), loader()), ConfigError);
  const Robot robot = Robot::live(yaml(sensors), loader());
  EXPECT_EQ(robot.source, nullptr);
  EXPECT_EQ(robot.sensors.at(0).plugin, "odometry");
  EXPECT_EQ(Robot::live(yaml("source: { plugin: no_such_plugin, any: thing }, " + sensors), loader()).source, nullptr);
}

TEST(Robot, TakesASensorOfTheProgramItself) {
  const Robot other = Robot::live(yaml("sensors: [" + kWheels + "]"), loader());
  const OwnSensors own{{"my_wheels", other.sensors.at(0).sensor}};
  const Robot robot = Robot::live(yaml("sensors: [{ name: wheels, plugin: my_wheels, my_key: 3 }]"), loader(), own);
  EXPECT_EQ(robot.sensors.at(0).sensor, other.sensors.at(0).sensor);
}

TEST(Robot, RefusesAKeyThatNothingReads) {
  EXPECT_THAT([] { Robot::live(yaml("sensors: [" + kWheels + "], sinsk: []"), loader()); },
              ThrowsMessage<ConfigError>(HasSubstr("sinsk")));
}

TEST(Robot, NamesThePayloadOfASensorThatHasNoPlugin) {
  const auto with = [](const std::string& plugin) {
    return [plugin] { Robot::live(yaml("sensors: [" + kWheels + ", { name: a, plugin: " + plugin + " }]"), loader()); };
  };
  const std::string hint = "; a scanner or a camera has no plugin: write payload: ";
  for (const std::string plugin : {"lidar", "laser", "scanner", "LaserScan"})
    EXPECT_THAT(with(plugin), ThrowsMessage<PluginError>(EndsWith(hint + "LaserScan instead"))) << plugin;
  EXPECT_THAT(with("camera"), ThrowsMessage<PluginError>(EndsWith(hint + "Image instead")));
  EXPECT_THAT(with("PointCloud"), ThrowsMessage<PluginError>(EndsWith(hint + "PointCloud instead")));
  EXPECT_THAT(with("odometri"), ThrowsMessage<PluginError>(EndsWith("; did you mean \"odometry\"?")));
}

TEST(Robot, ReadsOldNamesOfKeysAndSaysSo) {
  const std::string receiver =
      "{ name: gps, plugin: dgps, base_p_antenna_m: [0, 0, 0], sigma_m: 1, velocity_sigma_mps: 0.1, ";
  const std::string ours = "motion: { source: sensors }, sensors: [" + kTicks + ", " + receiver;
  EXPECT_THAT(Robot::load(yaml(kSource + ours + "heading_from_course: false }]"), loader()).settings.notices,
              IsEmpty());
  const std::string old = "motion: { told_by: sensors }, sensors: [" + kTicks + ", " + receiver;
  EXPECT_THAT(Robot::load(yaml(kSource + old + "course_tells_heading: false }]"), loader()).settings.notices,
              UnorderedElementsAre("motion.told_by: old name of `source`",
                                   "sensors[].course_tells_heading: old name of `heading_from_course`"));
  EXPECT_THAT(
      [&] {
        Robot::load(yaml(kSource + ours + "course_tells_heading: true, heading_from_course: false }]"), loader());
      },
      ThrowsMessage<ConfigError>(HasSubstr("course_tells_heading")));
}

TEST(Robot, NamesItsFileIfThePartsDoNotFit) {
  const std::string only_gps = "sensors: [{ name: gps, plugin: dgps, base_p_antenna_m: [0, 0, 0], sigma_m: 1 }]";
  const Robot robot = Robot::live(yaml(only_gps), loader());
  EXPECT_THAT([&] { robot.fusion(nullptr); }, ThrowsMessage<ConfigError>(StartsWith("robot.yaml: ")));
}

TEST(Robot, HasAtLeastOneSensor) {
  EXPECT_THAT([] { Robot::live(yaml("sensors: []"), loader()); },
              ThrowsMessage<ConfigError>(HasSubstr("a robot needs at least one motion source")));
}

}  // namespace
}  // namespace waymark::host
