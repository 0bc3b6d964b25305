// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "simulated_log.hpp"

namespace waymark {
namespace {

using test::kShortDrive;
using test::make_with;
using test::read_all;

constexpr double kGravity = 9.80665;

const std::string kExactImu =
    "gyroscope_noise_radps_per_sqrt_hz: 0, gyroscope_bias_sigma_radps: 0, gyroscope_bias_walk_radps_per_sqrt_s: 0,"
    "accelerometer_noise_mps2_per_sqrt_hz: 0, accelerometer_bias_sigma_mps2: 0,"
    "accelerometer_bias_walk_mps2_per_sqrt_s: 0, magnetometer_noise_t: 0";

struct Sample {
  double time_s;
  ImuSample imu;
};

std::vector<Sample> record_imu(const std::string& robot, const std::string& imu, const Pose& T_base_imu = {}) {
  const Rig rig({{.name = "imu", .payload = "", .T_base_sensor = T_base_imu}});
  std::vector<Sample> samples;
  for (const Measurement& m : read_all(*make_with(rig, robot + ", imu: { sensor: imu, " + imu + " } }"))) {
    samples.push_back({to_seconds(m.stamp.time_since_epoch()), m.as<ImuSample>()});
  }
  return samples;
}

/// The last heading of a drive.
double heading_of(const std::string& robot, const std::string& compass = "sigma_deg: 0", const Pose& T_base = {}) {
  const Rig rig({{.name = "compass", .payload = "", .T_base_sensor = T_base}});
  return read_all(*make_with(rig, robot + ", compass: { sensor: compass, " + compass + " } }"))
      .back()
      .as<CompassHeading>()
      .heading_rad;
}

double deviation(const std::vector<double>& values) {
  double mean = 0.0;
  for (const double v : values) mean += v / static_cast<double>(values.size());
  double variance = 0.0;
  for (const double v : values) variance += (v - mean) * (v - mean) / static_cast<double>(values.size() - 1);
  return std::sqrt(variance);
}

TEST(SimulatorImu, AtRestItMeasuresGravityAndTheEarth) {
  const Pose T_base_imu{so3::from_rpy(0.1, -0.2, 0.3), {0.4, 0.1, 0.2}};
  const auto samples = record_imu(kShortDrive + ", duration_s: 6, magnetism: { earth_field_t: [1e-6, 2e-5, -4e-5] }",
                                  kExactImu, T_base_imu);
  const ImuSample& imu = samples.back().imu;
  EXPECT_LT(imu.w_sensor.norm(), 1e-9);
  EXPECT_LT((T_base_imu.q * imu.f_sensor - Eigen::Vector3d(0.0, 0.0, kGravity)).norm(), 1e-9);
  // The robot faces east to a rounding.
  EXPECT_LT((T_base_imu.q * imu.m_sensor - Eigen::Vector3d(1e-6, 2e-5, -4e-5)).norm(), 1e-12);
}

TEST(SimulatorImu, SpecificForceIsTheAccelerationOfItsPlace) {
  // Half a m/s² for two seconds, from rest, straight ahead; the sensor looks to the left.
  const auto straight = record_imu("{ duration_s: 5, course: { waypoints_m: [0, 0, 30, 0] }", kExactImu,
                                   Pose::planar(0.3, 0.2, std::numbers::pi / 2.0));
  for (const Sample& sample : straight) {
    if (sample.time_s < 0.1 || (sample.time_s > 1.9 && sample.time_s < 2.1)) continue;
    const double expected = sample.time_s < 2.0 ? 0.5 : 0.0;
    ASSERT_NEAR(sample.imu.f_sensor.y(), -expected, 1e-6) << sample.time_s;
    ASSERT_NEAR(sample.imu.f_sensor.x(), 0.0, 1e-6);
  }
  // In a bend at constant speed the base accelerates towards its inside by speed times yaw rate, and a point ahead of
  // it that much less: -w² x.
  const std::string bend =
      "{ duration_s: 30, course: { waypoints_m: [0, 0, 10, 0, 10, 10], closed: false }, lookahead_m: 4";
  const auto base = record_imu(bend, kExactImu);
  const auto ahead = record_imu(bend, kExactImu, Pose::planar(0.5, 0.0, 0.0));
  ASSERT_EQ(base.size(), ahead.size());
  double fastest = 0.0;
  for (std::size_t i = 0; i < base.size(); ++i) {
    if (base[i].time_s < 3.0 || base[i].time_s > 20.0) continue;
    const double w = base[i].imu.w_sensor.z();
    fastest = std::max(fastest, w);
    // Pursuit changes the yaw rate fast, which the difference over 10 ms smears.
    ASSERT_NEAR(base[i].imu.f_sensor.y(), w * 1.0, 0.03) << base[i].time_s;
    ASSERT_NEAR(ahead[i].imu.f_sensor.x() - base[i].imu.f_sensor.x(), -0.5 * w * w, 0.01) << base[i].time_s;
  }
  EXPECT_GT(fastest, 0.2);
}

TEST(SimulatorImu, TheGyroscopeAddsUpToTheTurn) {
  const Rig rig({{.name = "imu", .payload = "", .T_base_sensor = Pose{}}});
  const auto source =
      make_with(rig,
                "{ duration_s: 30, course: { waypoints_m: [0, 0, 10, 0, 10, 10], closed: false }, imu: { sensor: imu, "
                "rate_hz: 200, " +
                    kExactImu + " } }");
  double turn = 0.0;
  for (const Measurement& m : read_all(*source)) turn += m.as<ImuSample>().w_sensor.z() / 200.0;
  const auto& truth = source->reference()->trajectory;
  EXPECT_NEAR(turn, truth.back().T_map_base.yaw() - truth.front().T_map_base.yaw(), 1e-3);
  EXPECT_GT(turn, 1.4);
}

TEST(SimulatorImu, WhiteNoiseHasTheStatedDensity) {
  std::string noisy = kExactImu;
  noisy.replace(noisy.find("hz: 0"), 5, "hz: 0.01");
  noisy.replace(noisy.find("hz: 0,", noisy.find("accelerometer_noise")), 5, "hz: 0.05");
  noisy.replace(noisy.find("noise_t: 0"), 10, "noise_t: 3e-7");
  for (const double rate : {25.0, 100.0}) {
    const auto samples = record_imu(kShortDrive + ", duration_s: 200", noisy + ", rate_hz: " + std::to_string(rate));
    std::vector<double> gyroscope;
    std::vector<double> accelerometer;
    std::vector<double> magnetometer;
    for (const Sample& sample : samples) {
      if (sample.time_s < 5.0) continue;
      gyroscope.push_back(sample.imu.w_sensor.y());
      accelerometer.push_back(sample.imu.f_sensor.z());
      magnetometer.push_back(sample.imu.m_sensor.x());
    }
    const double tolerance = 4.0 / std::sqrt(2.0 * static_cast<double>(gyroscope.size()));
    EXPECT_NEAR(deviation(gyroscope) / (0.01 * std::sqrt(rate)), 1.0, tolerance);
    EXPECT_NEAR(deviation(accelerometer) / (0.05 * std::sqrt(rate)), 1.0, tolerance);
    EXPECT_NEAR(deviation(magnetometer) / 3e-7, 1.0, tolerance);
  }
}

TEST(SimulatorImu, BiasesStartAtRandomAndWalk) {
  std::vector<double> starts;
  for (int seed = 1; seed <= 200; ++seed) {
    const auto samples = record_imu(kShortDrive + ", duration_s: 0.1, seed: " + std::to_string(seed),
                                    "gyroscope_noise_radps_per_sqrt_hz: 0, gyroscope_bias_sigma_radps: 0.02");
    starts.push_back(samples.front().imu.w_sensor.x());
    starts.push_back(samples.front().imu.w_sensor.y());
  }
  EXPECT_NEAR(deviation(starts) / 0.02, 1.0, 4.0 / std::sqrt(2.0 * 400.0));

  const auto samples = record_imu(kShortDrive + ", duration_s: 100",
                                  "rate_hz: 50, accelerometer_noise_mps2_per_sqrt_hz: 0,"
                                  "accelerometer_bias_walk_mps2_per_sqrt_s: 0.01");
  std::vector<double> steps;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    steps.push_back(samples[i].imu.f_sensor.z() - samples[i - 1].imu.f_sensor.z());
  }
  EXPECT_NEAR(deviation(steps) / (0.01 / std::sqrt(50.0)), 1.0, 4.0 / std::sqrt(2.0 * 5000.0));
}

TEST(SimulatorImu, ASensorOfSixAxesHasNoField) {
  const auto samples = record_imu(kShortDrive + ", duration_s: 1", "magnetometer: false");
  EXPECT_TRUE(std::isnan(samples.back().imu.m_sensor.x()));
  EXPECT_TRUE(samples.back().imu.w_sensor.allFinite());
}

TEST(SimulatorImu, MetalDisturbsTheFieldNearby) {
  const auto disturbance = [](const std::string& world) {
    const auto samples = record_imu(kShortDrive + ", duration_s: 6" + world, kExactImu);
    return (samples.back().imu.m_sensor - Eigen::Vector3d(0.0, 2e-5, -4.4e-5)).norm();
  };
  EXPECT_LT(disturbance(""), 1e-12);
  const std::string post = ", landmarks: { list_m: [1, 2, 0.1], textures: 2, list_texture: [1], metal_textures: ";
  EXPECT_LT(disturbance(post + "[0] }"), 1e-12);
  const double metal = disturbance(post + "[1] }");  // 20 A·m² at 2 m: 0.25 to 0.5 µT
  EXPECT_GT(metal, 2.4e-7);
  EXPECT_LT(metal, 5.1e-7);
  const double near = disturbance(", magnetism: { disturbers: [1, 1.5, 30] }");
  const double far = disturbance(", magnetism: { disturbers: [1, 3, 30] }");
  EXPECT_NEAR(near / far, 8.0, 0.02);
}

TEST(SimulatorCompass, ShowsWhereItsXAxisPoints) {
  const std::string east = "{ duration_s: 3, course: { waypoints_m: [0, 0, 9, 0] }";
  const std::string north = "{ duration_s: 3, course: { waypoints_m: [0, 0, 0, 9] }";
  EXPECT_NEAR(heading_of(north), 0.0, 1e-9);
  EXPECT_NEAR(heading_of(east), std::numbers::pi / 2.0, 1e-9);
  EXPECT_NEAR(heading_of(east, "sigma_deg: 0", Pose::planar(0.0, 0.0, 0.4)), std::numbers::pi / 2.0 - 0.4, 1e-9);
  EXPECT_NEAR(heading_of(north, "sigma_deg: 0, offset_deg: 9"), std::numbers::pi / 20.0, 1e-9);
  // Where the needle points 45° east of north, what points north shows -45°.
  EXPECT_NEAR(heading_of(north + ", magnetism: { earth_field_t: [2e-5, 2e-5, 0] }"), -std::numbers::pi / 4.0, 1e-9);
}

TEST(SimulatorCompass, MetalTurnsTheNeedle) {
  const std::string robot = kShortDrive + ", duration_s: 6";
  const double plain = heading_of(robot);
  const double near = heading_of(robot + ", magnetism: { disturbers: [1, 0.8, 20] }");
  const double far = heading_of(robot + ", magnetism: { disturbers: [1, 8, 20] }");
  EXPECT_GT(std::abs(near - plain), 0.01);
  EXPECT_LT(std::abs(far - plain), 0.001);
}

TEST(SimulatorMagnetism, ADisturbanceComesAndGoesAndTurnsWithTheRobot) {
  const std::string north = "{ duration_s: 9, course: { waypoints_m: [0, 0, 0, 9] }";
  const auto field = [&](const std::string& magnetism) {
    return record_imu(north + ", magnetism: { " + magnetism + " }", kExactImu);
  };
  const auto plain = field("metal_moment_am2: 0");
  const auto base = field("disturbances_s: [2, 4], disturbance_t: [3e-6, 1e-6, -2e-6]");
  const auto map = field("disturbances_s: [2, 4], disturbance_t: [3e-6, 1e-6, -2e-6], disturbance_frame: map");
  int disturbed = 0;
  for (std::size_t i = 0; i < plain.size(); ++i) {
    const bool on = plain[i].time_s >= 2.0 && plain[i].time_s < 4.0;
    disturbed += on ? 1 : 0;
    const Eigen::Vector3d of_robot = on ? Eigen::Vector3d(3e-6, 1e-6, -2e-6) : Eigen::Vector3d(0.0, 0.0, 0.0);
    // The robot looks north: what points east in the map points to its right.
    const Eigen::Vector3d of_map = on ? Eigen::Vector3d(1e-6, -3e-6, -2e-6) : Eigen::Vector3d(0.0, 0.0, 0.0);
    ASSERT_LT((base[i].imu.m_sensor - plain[i].imu.m_sensor - of_robot).norm(), 1e-12) << plain[i].time_s;
    ASSERT_LT((map[i].imu.m_sensor - plain[i].imu.m_sensor - of_map).norm(), 1e-12) << plain[i].time_s;
    ASSERT_EQ(base[i].imu.w_sensor, plain[i].imu.w_sensor);
  }
  EXPECT_EQ(disturbed, 200);
}

TEST(SimulatorMagnetism, ADisturbanceTurnsTheCompassToo) {
  const std::string north = "{ duration_s: 3, course: { waypoints_m: [0, 0, 0, 9] }";
  // As strong as the Earth's horizontal field, to the robot's right: the needle turns by 45°.
  EXPECT_NEAR(heading_of(north + ", magnetism: { disturbances_s: [0, 9], disturbance_t: [0, -2e-5, 0] }"),
              -std::numbers::pi / 4.0, 1e-9);
}

}  // namespace
}  // namespace waymark
