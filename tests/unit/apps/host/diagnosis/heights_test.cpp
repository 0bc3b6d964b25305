// SPDX-License-Identifier: Apache-2.0
// needs plugins: odometry, dgps, imu, altimeter
// Mistakes of an altimeter, a receiver's heights and an IMU on a robot that drives over hills.
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "tests/unit/apps/host/diagnosis/measurement_feed.hpp"
#include "waymark/host/diagnosis.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::host {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr const char* kYaml = R"({ motion: { kind: spatial }, initial: { x_m: 0, y_m: 0, yaw_deg: 0 },
  sensors: [{ name: wheels, plugin: odometry, model: differential, track_m: 0.5 },
            { name: imu, plugin: imu, base_T_sensor: { xyz_m: [0, 0, 0] } },
            { name: gps, plugin: dgps, base_p_antenna_m: [0, 0, 1.5], sigma_m: 0.5, sigma_vertical_m: 1 },
            { name: baro, plugin: altimeter, sigma_m: 0.2, base_T_sensor: { xyz_m: [0, 0, 0.5] } }] })";
enum Sensor : std::uint32_t { kWheels, kImu, kGps, kBarometer };

/// What is wrong besides.
struct Mistakes {
  std::string yaml = kYaml;
  double imu_yaw = 0.0;    ///< how the IMU is turned [rad]
  double imu_pitch = 0.0;  ///< [rad]
  double force_x = 1.0;    ///< factor
  double force_y = 1.0;
  double fix_height = 1.0;
  bool has_barometer = true;
  double pace = 0.05;  ///< of up and down [rad/s]
  double surge = 0.0;  ///< by how much the speed changes to and fro [m/s]
};

double right(double height) { return height; }

/// Hills of 6 m, and a barometer whose reading a mistake changes.
std::vector<Finding> examine(const std::function<double(double)>& mistake, const Mistakes& others = {}) {
  const Robot robot = Robot::live(Config::parse(others.yaml, "robot.yaml"), PluginLoader({WAYMARK_PLUGIN_DIR}));
  Diagnosis diagnosis(robot);
  std::mt19937 dice(7);
  std::normal_distribution<double> noise(0.0, 1.0);
  Eigen::Vector2d p = Eigen::Vector2d::Zero();
  double yaw = 0.3;
  double slow = 0.0;  // error of the fixes, correlated over a minute
  MeasurementFeed feed(diagnosis);
  for (int k = 0; k < 300 * 20; ++k) {
    const double t = 0.05 * k;
    const double rate = 0.4 * std::sin(0.23 * t);
    const double speed = 1.0 + others.surge * std::sin(0.8 * t);
    p += 0.05 * speed * Eigen::Vector2d(std::cos(yaw), std::sin(yaw));
    yaw += 0.05 * rate;
    slow += 0.05 / 60.0 * -slow + 0.5 * std::sqrt(2.0 * 0.05 / 60.0) * noise(dice);
    const double z = 6.0 * std::sin(others.pace * t);
    const double slope = 6.0 * others.pace * std::cos(others.pace * t);
    WheelSpeeds wheels;
    wheels.left_mps = speed - 0.25 * rate;
    wheels.right_mps = speed + 0.25 * rate;
    ImuSample imu;
    const double pitch_rate = 6.0 * others.pace * others.pace * std::sin(others.pace * t);  // as the slope falls
    imu.w_sensor = Eigen::AngleAxisd(-others.imu_yaw, Eigen::Vector3d::UnitZ()) *
                   Eigen::Vector3d(rate * slope / speed, pitch_rate / speed, rate + 0.01 * noise(dice));
    const double surging = 0.8 * others.surge * std::cos(0.8 * t);
    const double steepness = slope / speed;  // climbing takes its time at any speed
    const Eigen::Vector3d force(9.81 * steepness + surging + 0.2 * noise(dice), speed * rate + 0.2 * noise(dice), 9.81);
    imu.f_sensor = Eigen::AngleAxisd(-others.imu_pitch, Eigen::Vector3d::UnitY()) *
                   (Eigen::AngleAxisd(-others.imu_yaw, Eigen::Vector3d::UnitZ()) * force);
    imu.f_sensor.x() *= others.force_x;
    imu.f_sensor.y() *= others.force_y;
    feed.pass(kWheels, t, std::make_shared<WheelSpeeds>(wheels));
    feed.pass(kImu, t, std::make_shared<ImuSample>(imu));
    if (k % 10 == 0) {
      GnssFix fix;
      fix.p_map_antenna = {p.x() + 0.3 * noise(dice), p.y() + 0.3 * noise(dice),
                           others.fix_height * (z + 1.5 + slow + 0.5 * noise(dice))};
      feed.pass(kGps, t, std::make_shared<GnssFix>(fix));
    }
    if (others.has_barometer && k % 4 == 0) {
      Height height;
      height.height_m = mistake(z + 0.5 + 0.002 * t + 0.1 * noise(dice));
      feed.pass(kBarometer, t, std::make_shared<Height>(height));
    }
  }
  diagnosis.finish();
  return diagnosis.findings();
}

TEST(HeightDiagnosis, FindsNothingWithoutAMistake) { EXPECT_THAT(examine(right), IsEmpty()); }

TEST(HeightDiagnosis, OneOfBothIsInFeet) {
  const std::vector<Finding> findings = examine([](double height) { return height / 0.3048; });
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings.front().certainty, Finding::Certainty::one_of);
  EXPECT_THAT(findings.front().sensors, ElementsAre("baro", "gps"));
  EXPECT_THAT(findings.front().change, HasSubstr("height of baro times 0.3048 (feet)"));
}

TEST(HeightDiagnosis, NamesABarometerInCentimetres) {
  const std::vector<Finding> findings = examine([](double height) { return 100.0 * height; });
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings.front().certainty, Finding::Certainty::named);
  EXPECT_THAT(findings.front().sensors, ElementsAre("baro"));
  EXPECT_THAT(findings.front().change, HasSubstr("times 0.01 (cm)"));
}

TEST(HeightDiagnosis, NamesADepthThatIsTakenForAHeight) {
  const std::vector<Finding> findings = examine([](double height) { return -height; });
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings.front().certainty, Finding::Certainty::named);
  EXPECT_THAT(findings.front().sensors, ElementsAre("baro"));
}

TEST(HeightDiagnosis, FindsALevelOfTensOfMetres) {
  const auto above = [](double height) { return height + 48.0; };
  const std::vector<Finding> findings = examine(above);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings.front().certainty, Finding::Certainty::one_of);
  EXPECT_THAT(findings.front().change, HasSubstr("sensors.baro.level_m: -4"));
  // The same is no mistake if the offset is estimated.
  std::string yaml = kYaml;
  yaml.replace(yaml.find("sigma_m: 0.2"), 12, "sigma_m: 0.2, offset_sigma_m: 50");
  EXPECT_THAT(examine(above, {.yaml = yaml}), IsEmpty());
}

TEST(HeightDiagnosis, NamesABarometerThatRepeatsItsLastHeight) {
  const std::vector<Finding> findings = examine([last = 0.0, count = 0](double height) mutable {
    if (++count < 500) last = height;
    return last;
  });
  ASSERT_FALSE(findings.empty());
  EXPECT_EQ(findings.front().check, "frozen");
  EXPECT_THAT(findings.front().sensors, ElementsAre("baro"));
}

TEST(HeightDiagnosis, NamesABarometerThatRepeatsItsLastHeightWhereNobodyElseClimbs) {
  const auto repeats = [last = 0.0, count = 0](double height) mutable {
    if (++count < 500) last = height;
    return last;
  };
  const std::vector<Finding> findings = examine(repeats, {.fix_height = 0.0});
  ASSERT_FALSE(findings.empty());
  EXPECT_EQ(findings.front().check, "frozen");
  EXPECT_THAT(findings.front().sensors, ElementsAre("baro"));
}

/// As a drone that rises and sinks within the time in which heights are compared.
TEST(HeightDiagnosis, NamesABarometerThatRepeatsItsLastHeightAsOthersRiseAndSink) {
  std::string yaml = kYaml;
  for (const char* name : {"wheels", "imu"})
    yaml.replace(yaml.find(std::string("name: ") + name), 6, "enabled: false, name: ");
  const auto repeats = [last = 0.0, count = 0](double height) mutable {
    if (++count < 500) last = height;
    return last;
  };
  const std::vector<Finding> findings = examine(repeats, {.yaml = yaml, .pace = 0.314});
  ASSERT_FALSE(findings.empty());
  EXPECT_EQ(findings.front().check, "frozen");
  EXPECT_THAT(findings.front().sensors, ElementsAre("baro"));
}

TEST(HeightDiagnosis, FitsTheYawOfAnImuOnHills) {
  const std::vector<Finding> findings = examine(right, {.imu_yaw = 0.5 * M_PI});
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings.front().check, "acceleration");
  EXPECT_THAT(findings.front().sensors, ElementsAre("imu"));
}

TEST(HeightDiagnosis, HeightsAreIgnoredInThePlane) {
  std::string yaml = kYaml;
  yaml.replace(yaml.find("motion: { kind: spatial }, "), 27, "");
  EXPECT_THAT(examine([](double height) { return -height; }, {.yaml = yaml}), IsEmpty());
}

TEST(HeightDiagnosis, NamesAReceiverWhoseHeightsAreInFeetWithoutAnAltimeter) {
  std::string yaml = kYaml;
  yaml.erase(yaml.find(",\n            { name: baro"), std::string::npos);
  yaml += "] }";
  EXPECT_THAT(examine(right, {.yaml = yaml, .has_barometer = false}), IsEmpty());
  const std::vector<Finding> findings =
      examine(right, {.yaml = yaml, .fix_height = 1.0 / 0.3048, .has_barometer = false});
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_THAT(findings.front().sensors, ElementsAre("gps"));
  EXPECT_THAT(findings.front().change, HasSubstr("0.3048 (feet)"));
}

TEST(HeightDiagnosis, GravityShowsADepthBesideAReceiverThatWanders) {
  std::string yaml = kYaml;
  yaml.replace(yaml.find("sigma_vertical_m: 1"), 19, "sigma_vertical_m: 1, offset_vertical_sigma_m: 9");
  EXPECT_THAT(examine(right, {.yaml = yaml}), IsEmpty());
  const std::vector<Finding> depth = examine([](double height) { return -height; }, {.yaml = yaml, .surge = 0.3});
  // A part of the log may show the IMU in its place, before the hills do.
  ASSERT_FALSE(depth.empty());
  EXPECT_EQ(depth.back().certainty, Finding::Certainty::named);
  EXPECT_THAT(depth.back().sensors, ElementsAre("baro")) << describe(depth.back());
  const std::vector<Finding> feet = examine([](double height) { return height / 0.3048; }, {.yaml = yaml});
  ASSERT_EQ(feet.size(), 1U);
  EXPECT_THAT(feet.front().sensors, ElementsAre("baro"));
  EXPECT_THAT(feet.front().change, HasSubstr("(feet)"));
}

TEST(HeightDiagnosis, NamesADepthThatIsTakenForAHeightBesideAnImuAlone) {
  std::string yaml = kYaml;
  yaml.replace(yaml.find("name: gps"), 9, "enabled: false, name: gps");
  const std::vector<Finding> findings = examine([](double height) { return -height; }, {.yaml = yaml});
  ASSERT_FALSE(findings.empty());
  for (const Finding& finding : findings) EXPECT_THAT(finding.sensors, ElementsAre("baro")) << describe(finding);
  EXPECT_THAT(findings.back().change, HasSubstr("the opposite sign of the height of baro"));
}

TEST(HeightDiagnosis, NamesAnImuThatIsTilted) {
  EXPECT_THAT(examine(right, {.imu_pitch = 5.0 * M_PI / 180.0}), IsEmpty());
  const std::vector<Finding> findings = examine(right, {.imu_pitch = 15.0 * M_PI / 180.0});
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_THAT(findings.front().sensors, ElementsAre("imu"));
  EXPECT_THAT(findings.front().change, HasSubstr("pitch_deg: 15"));
}

TEST(HeightDiagnosis, NamesAnAxisOfTheAccelerometerWithTheOppositeSign) {
  for (const Mistakes& mistake : {Mistakes{.force_x = -1.0}, Mistakes{.force_y = -1.0}}) {
    const std::vector<Finding> findings = examine(right, mistake);
    ASSERT_EQ(findings.size(), 1U);
    EXPECT_THAT(findings.front().sensors, ElementsAre("imu"));
  }
}

}  // namespace
}  // namespace waymark::host
