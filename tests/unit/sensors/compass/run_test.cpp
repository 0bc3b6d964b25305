// SPDX-License-Identifier: Apache-2.0
// needs plugins: dgps, imu, odometry
// Whole runs of a robot with wheels, receiver and compass.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>

#include "unit/core/fusion_robot.hpp"
#include "waymark/math/random.hpp"

namespace waymark {
namespace {

using namespace test;  // NOLINT(google-build-using-namespace): the robot's parts
using ::testing::HasSubstr;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kSpeed = 1.0;
constexpr double kRate = 0.05;
constexpr double kEnd = 200.0;

double yaw_at(double t) { return 0.8 + kRate * t; }

/// Heading error of the device at t [rad].
using Error = std::function<double(double t)>;

/// The wheels see the turn rate with an error that grows to a full turn in the end; only the compass knows.
std::vector<Measurement> log_with(const Error& error, bool fixes = false, std::uint64_t seed = 5) {
  std::vector<Measurement> log;
  Random noise({.seed = seed, .slot = 0, .stamp = 0, .sensor = 0});
  for (int k = 0; k < static_cast<int>(kEnd) * 10; ++k) {
    const double t = 0.1 * k;
    log.push_back(twist(t, kSpeed, kRate + 0.01 * noise.normal()));
    auto payload = std::make_shared<CompassHeading>();
    payload->heading_rad = 0.5 * std::numbers::pi - yaw_at(t) + error(t) + 3.0 * kDegree * noise.normal();
    log.push_back(reading(t, 1, payload));
    if (!fixes || k % 10 != 0) continue;
    const double radius = kSpeed / kRate;
    const Eigen::Vector2d p(radius * (std::sin(yaw_at(t)) - std::sin(yaw_at(0.0))),
                            radius * (std::cos(yaw_at(0.0)) - std::cos(yaw_at(t))));
    log.push_back(fix(t, p.x() + 0.1 * noise.normal(), p.y() + 0.1 * noise.normal(), 2));
  }
  return in_order(std::move(log));
}

std::string robot(const std::string& initial, const std::string& keys = "", const std::string& more = "") {
  return initial + "sensors:\n" + kWheels +
         "  - { name: compass, plugin: compass, base_T_sensor: { yaw_deg: 0 }, declination: none, sigma_deg: 3" + keys +
         " }\n" + more;
}
const std::string kKnown = "initial: { x_m: 0, y_m: 0, position_sigma_m: 0.1, yaw_deg: 45.8, yaw_sigma_deg: 5 }\n";

double worst_heading(const FusionRobot& run, double from) {
  double worst = 0.0;
  for (const Seen& seen : run.seen()) {
    if (seen.stamp < from || seen.belief.P.size() == 0) continue;
    worst = std::max(worst, std::abs(so3::wrap(seen.belief.mean.T_map_base.yaw() - yaw_at(seen.stamp))));
  }
  return worst / kDegree;
}

double median(std::vector<double> values) {
  std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2));
  return values[values.size() / 2];
}

TEST(CompassRun, HoldsTheHeading) {
  FusionRobot run(robot(kKnown));
  run.play(log_with([](double) { return 0.0; }));
  EXPECT_LT(worst_heading(run, 5.0), 5.0);
}

TEST(CompassRun, FindsTheStartsHeading) {
  FusionRobot run(robot("initial: { x_m: 0, y_m: 0, position_sigma_m: 0.1 }\n"));
  run.play(log_with([](double) { return 0.0; }));
  ASSERT_TRUE(run.fusion().started());
  EXPECT_LT(worst_heading(run, 5.0), 5.0);
}

TEST(CompassRun, ADisturbanceShorterThanThePatienceDoesNotTurnTheRobot) {
  const Error passing = [](double t) { return t > 100.0 && t < 115.0 ? 70.0 * kDegree : 0.0; };
  FusionRobot run(robot(kKnown));
  run.play(log_with(passing));
  EXPECT_LT(worst_heading(run, 5.0), 6.0);
  EXPECT_EQ(run.events(), "");
}

TEST(CompassRun, AFilterThatIsWrongItselfLetsTheCompassIn) {
  FusionRobot run(robot("initial: { x_m: 0, y_m: 0, position_sigma_m: 0.1, yaw_deg: 170, yaw_sigma_deg: 2 }\n"));
  run.play(log_with([](double) { return 0.0; }));
  EXPECT_LT(worst_heading(run, 100.0), 6.0);
}

TEST(CompassRun, TheOffsetStateTakesAConstantErrorWhereFixesShowIt) {
  const Error constant = [](double) { return 8.0 * kDegree; };
  const std::string gps = "  - { name: gps, plugin: dgps, base_p_antenna_m: none, sigma_m: 0.1 }\n";
  std::vector<double> worst;
  std::vector<double> of_plain;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    FusionRobot plain(robot(kKnown, "", gps));
    plain.play(log_with(constant, true, seed));
    of_plain.push_back(worst_heading(plain, 60.0));
    FusionRobot with_offset(robot(kKnown, ", offset_sigma_deg: 8, offset_tau_s: 300", gps));
    with_offset.play(log_with(constant, true, seed));
    worst.push_back(worst_heading(with_offset, 60.0));
  }
  EXPECT_LT(median(worst), 4.0) << testing::PrintToString(worst);
  EXPECT_LT(median(worst), 0.7 * median(of_plain)) << testing::PrintToString(of_plain);
}

// --- one magnetometer, one heading ---------------------------------------------------------------------------------

std::string refusal(const std::string& imu_keys, const std::string& compass_keys) {
  try {
    FusionRobot run(
        robot(kKnown, compass_keys, "  - { name: imu, plugin: imu, base_T_sensor: { yaw_deg: 0 }" + imu_keys + " }\n"));
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

TEST(Magnetometers, OneDoesNotFeedImuAndCompass) {
  // `declination: none` is not a magnetometer, so this compass has a declination.
  const std::string magnetic =
      kKnown + "sensors:\n" + kWheels +
      "  - { name: compass, plugin: compass, base_T_sensor: { yaw_deg: 0 }, declination_deg: 3KEYS }\n"
      "  - { name: imu, plugin: imu, base_T_sensor: { yaw_deg: 0 }IMU }\n";
  const auto text = [&](const std::string& compass, const std::string& imu) -> std::string {
    std::string yaml = magnetic;
    yaml.replace(yaml.find("KEYS"), 4, compass);
    yaml.replace(yaml.find("IMU"), 3, imu);
    try {
      FusionRobot run(yaml);
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(text("", ", heading: true"), HasSubstr("sensors.compass and sensors.imu"));
  EXPECT_THAT(text("", ", heading: true, orientation: device"), HasSubstr("own_magnetometer: true"));
  EXPECT_EQ(text("", ""), "");
  EXPECT_EQ(text(", own_magnetometer: true", ", heading: true"), "");
  EXPECT_EQ(text("", ", heading: true, own_magnetometer: true"), "");
  EXPECT_EQ(text(", enabled: false", ", heading: true"), "");
}

TEST(Magnetometers, AGyrocompassHasNone) { EXPECT_EQ(refusal(", heading: true", ""), ""); }

}  // namespace
}  // namespace waymark
