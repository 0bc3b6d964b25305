// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "simulated_log.hpp"
#include "waymark/base/error.hpp"

namespace waymark {
namespace {

using test::kShortDrive;
using test::kWheels;
using test::make;
using test::make_with;
using test::read_all;

constexpr double kDeg = std::numbers::pi / 180.0;

/// A room of 40 m by 40 m around the drive, and a robot that soon drives at 2 m/s.
const std::string kRoom =
    "{ duration_s: 8, speed_mps: 2, acceleration_mps2: 10, course: { waypoints_m: [-15, 0, 15, 0] },"
    " walls_m: [-20, -20, 20, -20,  20, -20, 20, 20,  20, 20, -20, 20,  -20, 20, -20, -20]";
const std::string kExactRadar =
    ", radars: [{ sensor: lidar, range_sigma_m: 0, azimuth_sigma_deg: 0, radial_sigma_mps: 1e-9";

Pose mounted(double yaw_rad, double roll_rad = 0.0) { return {so3::from_rpy(roll_rad, 0.0, yaw_rad), {1.0, 0.5, 0.4}}; }

std::vector<RadarTargets::One> last_scan(const std::string& keys, const Pose& pose, const std::string& world = kRoom) {
  return read_all(*make(world + kExactRadar + keys + " }] }", pose)).back().as<RadarTargets>().targets;
}

Eigen::Vector3d ray(const RadarTargets::One& one) {
  return {std::cos(one.elevation_rad) * std::cos(one.azimuth_rad),
          std::cos(one.elevation_rad) * std::sin(one.azimuth_rad), std::sin(one.elevation_rad)};
}

TEST(SimulatedRadar, WhatStandsStillComesWithTheSpeedOfTheRadar) {
  for (const double yaw : {0.0, 1.2, -2.5}) {
    const auto targets = last_scan("", mounted(yaw));
    ASSERT_EQ(targets.size(), 100u);  // the walls are all around
    // Straight ahead at 2 m/s.
    const Eigen::Vector3d v(2.0 * std::cos(yaw), -2.0 * std::sin(yaw), 0.0);
    for (const RadarTargets::One& one : targets) {
      ASSERT_NEAR(one.radial_mps, -ray(one).dot(v), 1e-6);
      ASSERT_LE(std::abs(one.azimuth_rad), 60.0 * kDeg);
      ASSERT_EQ(one.elevation_rad, 0.0);
    }
  }
}

TEST(SimulatedRadar, TheRangeIsThatOfTheSurface) {
  const Pose pose = mounted(0.3);
  const auto all = read_all(*make(kRoom + kExactRadar + ", view_deg: 20 }] }", pose));
  for (const Measurement& m : all) {
    for (const RadarTargets::One& one : m.as<RadarTargets>().targets) {
      // The wall at x = 20; the robot is on y = 0, and starts at x = -15.
      const double from_start = 20.0 - one.range_m * std::cos(one.azimuth_rad + 0.3) - 1.0 + 15.0;
      const double driven = 2.0 * (to_seconds(m.stamp.time_since_epoch()) - 0.1);
      if (std::abs(one.range_m * std::sin(one.azimuth_rad + 0.3)) > 19.0) continue;
      ASSERT_NEAR(from_start, std::max(0.0, driven), 0.15);
    }
  }
}

TEST(SimulatedRadar, WithAHeightOfViewTheDirectionHasAnElevation) {
  const auto targets = last_scan(", rise_deg: 40, elevation_sigma_deg: 0", mounted(0.0, 0.1));
  ASSERT_GT(targets.size(), 50u);  // the ground and the walls, not the sky
  const Eigen::Vector3d v(2.0, 0.0, 0.0);
  double highest = 0.0;
  for (const RadarTargets::One& one : targets) {
    ASSERT_NEAR(one.radial_mps, -ray(one).dot(v), 1e-6);
    highest = std::max(highest, std::abs(one.elevation_rad));
  }
  EXPECT_GT(highest, 15.0 * kDeg);
  EXPECT_LE(highest, 20.0 * kDeg);
}

TEST(SimulatedRadar, TrafficHasAVelocityOfItsOwn) {
  // Without rays only the traffic is left, within a narrow strip ahead.
  const std::string traffic = ", traffic: { count: 30, area_m: [-18, -5, 18, 5], speed_mps: [4, 4] }";
  const auto targets = last_scan(", rays: 0, view_deg: 180, targets_per_thing: 4", mounted(0.0), kRoom + traffic);
  ASSERT_GT(targets.size(), 10u);
  int moving = 0;
  for (const RadarTargets::One& one : targets) {
    const double of_its_own = one.radial_mps + 2.0 * std::cos(one.azimuth_rad);
    ASSERT_LE(std::abs(of_its_own), 4.0 + 1e-6);
    moving += std::abs(of_its_own) > 0.5 ? 1 : 0;
  }
  EXPECT_GT(moving, 5);
}

TEST(SimulatedRadar, WallsHideTraffic) {
  // A wall right before the radar.
  const std::string hidden =
      kShortDrive + ", duration_s: 6, walls_m: [3, -50, 3, 50]" + ", traffic: { count: 50, area_m: [5, -20, 30, 20] }";
  EXPECT_TRUE(last_scan(", rays: 0", {}, hidden).empty());
}

TEST(SimulatedRadar, FalseAlarmsAreWithinWhatTheRadarMeasures) {
  const auto all = read_all(
      *make(kRoom + kExactRadar + ", rays: 0, false_alarms_per_scan: 20, range_max_m: 30, radial_max_mps: 15 }] }"));
  double sum = 0.0;
  for (const Measurement& m : all) {
    const auto& targets = m.as<RadarTargets>().targets;
    sum += static_cast<double>(targets.size());
    for (const RadarTargets::One& one : targets) {
      ASSERT_LE(one.range_m, 30.0);
      ASSERT_LE(std::abs(one.radial_mps), 15.0);
      ASSERT_LE(std::abs(one.azimuth_rad), 60.0 * kDeg);
    }
  }
  const auto n = static_cast<double>(all.size());
  EXPECT_NEAR(sum / n, 20.0, 4.0 * std::sqrt(20.0 / n));
}

TEST(SimulatedRadar, AnEchoThatBouncesTwiceIsTwiceAsFarAndTwiceAsFast) {
  const auto once = last_scan(", range_max_m: 100", mounted(0.0));
  const auto twice = last_scan(", range_max_m: 100, multipath_probability: 1", mounted(0.0));
  ASSERT_EQ(twice.size(), 2 * once.size());
  for (std::size_t i = 0; i < once.size(); ++i) {
    ASSERT_EQ(twice[2 * i].range_m, once[i].range_m);
    ASSERT_NEAR(twice[2 * i + 1].range_m, 2.0 * once[i].range_m, 1e-9);
    ASSERT_NEAR(twice[2 * i + 1].radial_mps, 2.0 * once[i].radial_mps, 1e-6);
  }
}

TEST(SimulatedRadar, ASpeedBeyondTheLimitIsAmbiguous) {
  for (const RadarTargets::One& one : last_scan(", radial_max_mps: 1.2", mounted(0.0))) {
    const double true_mps = -2.0 * std::cos(one.azimuth_rad);
    ASSERT_NEAR(one.radial_mps, true_mps < -1.2 ? true_mps + 2.4 : true_mps, 1e-6);
  }
}

TEST(SimulatedRadar, NoiseHasTheStatedSigma) {
  const auto all = read_all(
      *make(kRoom + ", radars: [{ sensor: lidar, azimuth_sigma_deg: 0, radial_sigma_mps: 0.2 }] }", mounted(0.4)));
  double squares = 0.0;
  double n = 0.0;
  for (const Measurement& m : all) {
    if (to_seconds(m.stamp.time_since_epoch()) < 1.0) continue;
    for (const RadarTargets::One& one : m.as<RadarTargets>().targets) {
      const double error = one.radial_mps + 2.0 * std::cos(one.azimuth_rad + 0.4);
      squares += error * error;
      n += 1.0;
    }
  }
  EXPECT_NEAR(squares / n, 0.04, 4.0 * 0.04 * std::sqrt(2.0 / n));
}

TEST(SimulatedRadar, SeveralDrawForThemselves) {
  const Rig rig({{.name = "left", .payload = "", .T_base_sensor = mounted(0.5)},
                 {.name = "right", .payload = "", .T_base_sensor = mounted(0.5)},
                 {.name = "wheels", .payload = "", .T_base_sensor = {}}});
  const auto targets_of = [&](const std::string& yaml, const std::string& sensor) {
    const auto source = make_with(rig, yaml);
    std::vector<double> radial;
    for (const Measurement& m : read_all(*source)) {
      if (source->channels()[m.sensor].sensor != sensor) continue;
      for (const RadarTargets::One& one : m.as<RadarTargets>().targets) radial.push_back(one.radial_mps);
    }
    return radial;
  };
  const auto one = targets_of(kRoom + ", radars: [{ sensor: left }] }", "left");
  const std::string both = kRoom + kWheels + ", radars: [{ sensor: left }, { sensor: right }] }";
  EXPECT_EQ(targets_of(both, "left"), one);
  EXPECT_NE(targets_of(both, "right"), one);
  EXPECT_NE(targets_of(kRoom + ", seed: 5, radars: [{ sensor: left }] }", "left"), one);
}

TEST(SimulatedRadar, RefusesWhatIsNoRadar) {
  const auto refused = [](const std::string& keys) -> std::string {
    try {
      make(kRoom + keys + " }");
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(refused(", radars: [{ sensor: lidar, view_deg: 200 }]").find("view_deg"), std::string::npos);
  EXPECT_NE(refused(", radars: [{ sensor: lidar, radial_sigma_mps: 0 }]").find("radial_sigma_mps"), std::string::npos);
  EXPECT_NE(refused(kWheels + ", traffic: { count: 3 }").find("area_m"), std::string::npos);
  EXPECT_NE(refused(kWheels + ", traffic: { count: 3, area_m: [5, 0, 1, 9] }").find("x_min < x_max"),
            std::string::npos);
  EXPECT_NE(refused(kWheels + ", traffic: { count: 3, area_m: [0, 0, 1, 9], speed_mps: [3, 2] }").find("speed_mps"),
            std::string::npos);
}

TEST(SimulatedRadar, CanBeSpoiltAsTheOthers) {
  const auto all =
      read_all(*make(kRoom + ", radars: [{ sensor: lidar, rate_hz: 2, nan_s: [1, 2], dead_s: [3, 4] }] }"));
  int spoilt = 0;
  for (const Measurement& m : all) {
    const double time = to_seconds(m.stamp.time_since_epoch());
    ASSERT_FALSE(time >= 3.0 && time < 4.0);
    const auto& targets = m.as<RadarTargets>().targets;
    ASSERT_FALSE(targets.empty());
    ASSERT_EQ(std::isnan(targets.front().radial_mps), time >= 1.0 && time < 2.0);
    spoilt += std::isnan(targets.front().radial_mps) ? 1 : 0;
  }
  EXPECT_EQ(spoilt, 2);
}

}  // namespace
}  // namespace waymark
