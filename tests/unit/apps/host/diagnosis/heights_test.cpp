// SPDX-License-Identifier: Apache-2.0
// needs plugins: odometry, dgps, imu, altimeter
// Mistakes of an altimeter on a robot that drives over hills.
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <random>

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

/// Hills of 6 m, and a barometer whose reading a mistake changes. `imu_yaw` [rad]: how the IMU is turned.
std::vector<Finding> examine(const std::function<double(double)>& mistake, const std::string& yaml = kYaml,
                             double imu_yaw = 0.0) {
  const Robot robot = Robot::live(Config::parse(yaml, "robot.yaml"), PluginLoader({WAYMARK_PLUGIN_DIR}));
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
    p += 0.05 * Eigen::Vector2d(std::cos(yaw), std::sin(yaw));
    yaw += 0.05 * rate;
    slow += 0.05 / 60.0 * -slow + 0.5 * std::sqrt(2.0 * 0.05 / 60.0) * noise(dice);
    const double z = 6.0 * std::sin(0.05 * t);
    const double slope = 0.3 * std::cos(0.05 * t);
    WheelSpeeds wheels;
    wheels.left_mps = 1.0 - 0.25 * rate;
    wheels.right_mps = 1.0 + 0.25 * rate;
    ImuSample imu;
    imu.w_sensor = {0.0, 0.0, rate + 0.01 * noise(dice)};
    const Eigen::Vector2d force(9.81 * slope + 0.2 * noise(dice), rate + 0.2 * noise(dice));
    imu.f_sensor << Eigen::Rotation2Dd(-imu_yaw) * force, 9.81;
    feed.pass(kWheels, t, std::make_shared<WheelSpeeds>(wheels));
    feed.pass(kImu, t, std::make_shared<ImuSample>(imu));
    if (k % 10 == 0) {
      GnssFix fix;
      fix.p_map_antenna = {p.x() + 0.3 * noise(dice), p.y() + 0.3 * noise(dice), z + 1.5 + slow + 0.5 * noise(dice)};
      feed.pass(kGps, t, std::make_shared<GnssFix>(fix));
    }
    if (k % 4 == 0) {
      Height height;
      height.height_m = mistake(z + 0.5 + 0.002 * t + 0.1 * noise(dice));
      feed.pass(kBarometer, t, std::make_shared<Height>(height));
    }
  }
  diagnosis.finish();
  return diagnosis.findings();
}

TEST(HeightDiagnosis, FindsNothingWithoutAMistake) {
  EXPECT_THAT(examine([](double height) { return height; }), IsEmpty());
}

TEST(HeightDiagnosis, OneOfBothIsInFeet) {
  const std::vector<Finding> findings = examine([](double height) { return height / 0.3048; });
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings.front().certainty, Finding::Certainty::one_of);
  EXPECT_THAT(findings.front().sensors, ElementsAre("baro", "gps"));
  EXPECT_THAT(findings.front().change, HasSubstr("height of baro times 0.3048 (feet)"));
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
  EXPECT_THAT(examine(above, yaml), IsEmpty());
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

TEST(HeightDiagnosis, FitsTheYawOfAnImuOnHills) {
  const std::vector<Finding> findings = examine([](double height) { return height; }, kYaml, 0.5 * M_PI);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings.front().check, "acceleration");
  EXPECT_THAT(findings.front().sensors, ElementsAre("imu"));
}

TEST(HeightDiagnosis, HeightsAreIgnoredInThePlane) {
  std::string yaml = kYaml;
  yaml.replace(yaml.find("motion: { kind: spatial }, "), 27, "");
  EXPECT_THAT(examine([](double height) { return -height; }, yaml), IsEmpty());
}

}  // namespace
}  // namespace waymark::host
