// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <numbers>
#include <string>
#include <vector>

#include "simulated_log.hpp"

namespace waymark {
namespace {

using test::kShortDrive;
using test::kWheels;
using test::make;
using test::read_all;

constexpr double kHeight = 0.8;  // of the scanner
constexpr double kDeg = std::numbers::pi / 180.0;

Pose mounted(double roll = 0.0, double pitch = 0.0, double yaw = 0.0, double z = kHeight) {
  return {so3::from_rpy(roll, pitch, yaw), {0.0, 0.0, z}};
}

/// Beams in rows: each a cone of the elevations -20, -10, 0, 10, 20 degrees.
const std::string kExact =
    ", lidar_3d: { sensor: lidar, sigma_m: 1e-9, rings: 5, elevation_min_deg: -20, elevation_max_deg: 20, step_deg: 2,"
    " beams: 180, range_max_m: 12 } }";

/// The last cloud of a robot that stands at x = 1 (to a millimetre) and looks east, in the map's axes with the origin
/// in the scanner.
std::vector<Eigen::Vector3d> cloud_of(const std::string& world, const Pose& T_base_lidar = mounted(),
                                      const std::string& lidar = kExact) {
  const auto source = make(kShortDrive + ", duration_s: 6" + world + lidar, T_base_lidar);
  const std::vector<Measurement> all = read_all(*source);
  const std::vector<Eigen::Vector3f>& seen = all.back().as<PointCloud>().points_m;
  std::vector<Eigen::Vector3d> points;
  points.reserve(seen.size());
  for (const Eigen::Vector3f& p : seen) points.emplace_back(T_base_lidar.q * p.cast<double>());
  return points;
}

/// Elevation and azimuth [deg] of what came back.
double elevation(const Eigen::Vector3d& p) { return std::atan2(p.z(), p.head<2>().norm()) / kDeg; }
double azimuth(const Eigen::Vector3d& p) { return std::atan2(p.y(), p.x()) / kDeg; }

TEST(SimulatedLidar3d, TheGroundIsSeenByAllThatLooksDownFarEnough) {
  const auto points = cloud_of("");
  // At -20 and -10 degrees the ground is 2.34 and 4.61 m away; the other rings look level or up.
  ASSERT_EQ(points.size(), 2u * 180u);
  for (const Eigen::Vector3d& p : points) ASSERT_NEAR(p.z(), -kHeight, 1e-5);
  EXPECT_NEAR(points[0].norm(), kHeight / std::sin(20.0 * kDeg), 1e-5);
  EXPECT_NEAR(points[1].norm(), kHeight / std::sin(10.0 * kDeg), 1e-5);
  EXPECT_TRUE(cloud_of(", ground: false").empty());
}

TEST(SimulatedLidar3d, OnlyReturnsWithinTheRangeAreInTheCloud) {
  const std::string near =
      ", lidar_3d: { sensor: lidar, sigma_m: 1e-9, rings: 5, elevation_min_deg: -20, elevation_max_deg: 20, step_deg: "
      "2,"
      " beams: 180, range_max_m: 3 } }";
  EXPECT_EQ(cloud_of("", mounted(), near).size(), 180u);
  const std::string none =
      ", lidar_3d: { sensor: lidar, sigma_m: 1e-9, rings: 5, elevation_min_deg: -20, elevation_max_deg: 20, step_deg: "
      "2,"
      " beams: 180, range_max_m: 2 } }";
  EXPECT_TRUE(cloud_of("", mounted(), none).empty());
}

TEST(SimulatedLidar3d, TheCeilingIsSeenFromBelow) {
  const auto points = cloud_of(", ground: false, ceiling_m: 2.8");
  ASSERT_EQ(points.size(), 2u * 180u);
  for (const Eigen::Vector3d& p : points) ASSERT_NEAR(p.z(), 2.0, 1e-5);
}

TEST(SimulatedLidar3d, AWallEndsAtItsHeight) {
  // 4 m ahead, 1.2 m high: 0.4 m above the scanner, so the beams at 10 degrees pass over it.
  const auto points = cloud_of(", ground: false, walls_m: [5, -3, 5, 3], wall_height_m: 1.2");
  int rings[5] = {};
  for (const Eigen::Vector3d& p : points) {
    ASSERT_NEAR(p.x(), 4.0, 2e-3);
    ASSERT_LE(std::abs(p.y()), 3.0);
    ASSERT_GE(p.z(), -kHeight - 1e-6);
    ASSERT_LE(p.z(), 0.4 + 1e-6);
    ++rings[std::lround(elevation(p) / 10.0) + 2];
  }
  // Columns within atan(3 / 4) = 36.87 degrees: 37. The ring at -20 degrees drops below z = 0 before the wall, that at
  // -10 degrees does so where the wall is further than 0.8 / tan(10 deg) = 4.54 m, beyond 28.2 degrees: 29 columns.
  EXPECT_EQ(rings[0], 0);
  EXPECT_EQ(rings[1], 29);
  EXPECT_EQ(rings[2], 37);
  EXPECT_EQ(rings[3], 0);
  EXPECT_EQ(rings[4], 0);
}

TEST(SimulatedLidar3d, ACylinderHasASideAndATop) {
  // A stump of 0.5 m height, 2 m ahead: near its axis the beams at -10 degrees pass over its edge, 1.5 m ahead at 0.54
  // m height, and come down on its top 1.7 m ahead; those at -20 degrees meet its side.
  const std::string stump = ", landmarks: { list_m: [3, 0, 0.5], height_m: [0.5, 0.5] }";
  int side = 0;
  int top = 0;
  for (const Eigen::Vector3d& p : cloud_of(", ground: false" + stump)) {
    const Eigen::Vector3d at(p.x() + 1.0, p.y(), p.z() + kHeight);
    const double from_axis = std::hypot(at.x() - 3.0, at.y());
    if (std::abs(at.z() - 0.5) < 2e-3 && from_axis < 0.499) {
      ++top;
      EXPECT_NEAR(elevation(p), -10.0, 0.01);
      EXPECT_NEAR(p.norm(), 0.3 / std::sin(10.0 * kDeg), 1e-5);
    } else {
      ++side;
      ASSERT_NEAR(from_axis, 0.5, 3e-3);
      ASSERT_GT(at.z(), 0.0);
      ASSERT_LT(at.z(), 0.5);
      ASSERT_LT((at - Eigen::Vector3d(3.0, 0.0, at.z())).dot(p), 0.0) << "the far side is not seen";
    }
  }
  EXPECT_GT(top, 5);
  EXPECT_GT(side, 10);
}

TEST(SimulatedLidar3d, ABoxHasSidesAndATop) {
  // x from 2.5 to 3.5, y from -1 to 1, 0.5 m high: the robot at x = 1 sees its near side 1.5 m ahead, and its top
  // behind that with the beams at -10 degrees.
  int side = 0;
  int top = 0;
  for (const Eigen::Vector3d& p : cloud_of(", ground: false, boxes_m: [3, 0, 1, 2, 0.5]")) {
    const Eigen::Vector3d at(p.x() + 1.0, p.y(), p.z() + kHeight);
    ASSERT_LE(std::abs(at.y()), 1.0 + 2e-3);
    ASSERT_GE(at.x(), 2.5 - 2e-3);
    ASSERT_LE(at.x(), 3.5 + 2e-3);
    if (std::abs(at.x() - 2.5) < 2e-3) {
      ++side;
      ASSERT_LE(at.z(), 0.5);
    } else {
      ++top;
      ASSERT_NEAR(at.z(), 0.5, 1e-5);
      ASSERT_NEAR(p.norm(), 0.3 / std::sin(10.0 * kDeg), 1e-5);
    }
  }
  EXPECT_GT(side, 20);
  EXPECT_GT(top, 20);
}

TEST(SimulatedLidar3d, TheNearestSurfaceHidesTheOthers) {
  const std::string two = ", ground: false, walls_m: [5, -3, 5, 3,  7, -3, 7, 3], wall_height_m: 3";
  for (const Eigen::Vector3d& p : cloud_of(two)) {
    if (std::abs(azimuth(p)) > 35.0) continue;  // beyond the end of the near wall
    ASSERT_NEAR(p.x(), 4.0, 2e-3);
  }
}

TEST(SimulatedLidar3d, StraightUpAndDownWork) {
  const std::string vertical =
      ", lidar_3d: { sensor: lidar, sigma_m: 1e-9, rings: 2, elevation_min_deg: -90, elevation_max_deg: 90, beams: 4,"
      " step_deg: 90 } }";
  const auto points = cloud_of(", ceiling_m: 3, walls_m: [5, -3, 5, 3]", mounted(), vertical);
  ASSERT_EQ(points.size(), 8u);
  for (std::size_t i = 0; i < 8; ++i) EXPECT_NEAR(points[i].z(), i % 2 == 0 ? -kHeight : 2.2, 1e-5);
  // Over a box the ground is its top.
  const Pose T_base_lidar{Eigen::Quaterniond::Identity(), {1.0, 0.0, 1.5}};
  const auto over_box = cloud_of(", boxes_m: [2, 0, 0.6, 0.6, 1]", T_base_lidar, vertical);
  ASSERT_EQ(over_box.size(), 4u);
  EXPECT_NEAR(over_box[0].z(), -0.5, 1e-5);
}

TEST(SimulatedLidar3d, IsMountedInAnyOrientation) {
  // Lying on its side, and pitched and yawed: the same planes, wherever the beams point.
  for (const Pose& pose : {mounted(90.0 * kDeg), mounted(0.2, 0.3, 1.0), mounted(-1.2, 0.4, 2.5, 1.3)}) {
    const auto points = cloud_of(", ceiling_m: 2.5, walls_m: [9, -30, 9, 30]", pose);
    ASSERT_GT(points.size(), 300u);
    for (const Eigen::Vector3d& p : points) {
      const double to_plane =
          std::min({std::abs(p.z() + pose.p.z()), std::abs(p.z() - (2.5 - pose.p.z())), std::abs(p.x() - 8.0)});
      ASSERT_LT(to_plane, 2e-3);
      ASSERT_LT(p.norm(), 12.0);
    }
  }
}

TEST(SimulatedLidar3d, RangeNoiseHasTheStatedSigma) {
  const std::string noisy =
      ", lidar_3d: { sensor: lidar, sigma_m: 0.05, rings: 2, elevation_min_deg: -60, elevation_max_deg: -30, beams: 90,"
      " step_deg: 4, rate_hz: 5 } }";
  const auto source = make(kShortDrive + ", duration_s: 20" + noisy, mounted());
  double sum = 0.0;
  double squares = 0.0;
  double n = 0.0;
  for (const Measurement& m : read_all(*source)) {
    for (const Eigen::Vector3f& p : m.as<PointCloud>().points_m) {
      const Eigen::Vector3d v = p.cast<double>();
      const double error = v.norm() - kHeight / std::sin(-elevation(v) * kDeg);
      sum += error;
      squares += error * error;
      n += 1.0;
    }
  }
  ASSERT_EQ(n, 100.0 * 180.0);
  EXPECT_NEAR(sum / n, 0.0, 4.0 * 0.05 / std::sqrt(n));
  EXPECT_NEAR(squares / n, 0.0025, 4.0 * 0.0025 * std::sqrt(2.0 / n));
}

TEST(SimulatedLidar3d, WithASweepEveryPointIsSeenFromWhereTheRobotThenWas) {
  const auto source = make(
      "{ duration_s: 4, acceleration_mps2: 1000, course: { waypoints_m: [0, 0, 20, 0] }, walls_m: [30, -50, 30, 50],"
      " ground: false, lidar_3d: { sensor: lidar, rate_hz: 5, sigma_m: 1e-9, rings: 1, elevation_min_deg: 0,"
      " elevation_max_deg: 0, start_deg: -30, beams: 61, sweep_s: 0.1, range_max_m: 60 } }",
      mounted());
  for (const Measurement& m : read_all(*source)) {
    const auto& cloud = m.as<PointCloud>();
    ASSERT_EQ(cloud.points_m.size(), 61u);
    ASSERT_EQ(cloud.offsets_s.size(), 61u);
    const double start = to_seconds(m.stamp.time_since_epoch());
    for (std::size_t i = 0; i < 61; ++i) {
      const auto offset = static_cast<double>(cloud.offsets_s[i]);
      ASSERT_NEAR(offset, 0.1 * static_cast<double>(i) / 61.0, 1e-7);
      ASSERT_NEAR(static_cast<double>(cloud.points_m[i].x()), 30.0 - (start + offset), 6e-3);  // 1 m/s in steps of 5 ms
    }
  }
  EXPECT_TRUE(
      read_all(*make(kShortDrive + ", duration_s: 2" + kExact, mounted())).back().as<PointCloud>().offsets_s.empty());
}

TEST(SimulatedLidar3d, IsNeitherInTheGroundNorAboveTheCeiling) {
  const auto refused = [](const std::string& world, double z) -> std::string {
    try {
      make(kShortDrive + ", duration_s: 6" + world + kExact, mounted(0.0, 0.0, 0.0, z));
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(refused("", 0.0).find("z = 0 m; more than 0, above the ground"), std::string::npos);
  EXPECT_NE(refused(", ceiling_m: 2.5", 2.5).find("less than ceiling_m = 2.5"), std::string::npos);
  EXPECT_EQ(refused(", ground: false", -1.0), "");
  EXPECT_EQ(refused(", ceiling_m: 2.5", 2.4), "");
}

bool same_points(const Measurement& a, const Measurement& b) {
  const auto& left = a.as<PointCloud>().points_m;
  const auto& right = b.as<PointCloud>().points_m;
  return left.size() == right.size() &&
         std::memcmp(left.data(), right.data(), left.size() * sizeof(Eigen::Vector3f)) == 0;
}

TEST(SimulatedLidar3d, DrawsForItself) {
  const std::string world = kShortDrive + ", duration_s: 4, walls_m: [9, -9, 9, 9], clutter: { boxes: 3, stones: 3, " +
                            "area_m: [-8, -8, 8, 8] }";
  const std::string cloud = ", lidar_3d: { sensor: lidar, beams: 90, step_deg: 4, rate_hz: 3 }";
  const auto clouds = read_all(*make(world + cloud + " }", mounted()));
  const auto again = read_all(*make(world + cloud + " }", mounted()));
  const auto other = read_all(*make(world + cloud + ", seed: 2 }", mounted()));
  const auto plain = read_all(*make(world + kWheels + " }", mounted()));
  const auto both = read_all(*make(world + kWheels + cloud + " }", mounted()));
  ASSERT_EQ(clouds.size(), again.size());
  ASSERT_EQ(both.size(), clouds.size() + plain.size());
  std::size_t k = 0;
  std::size_t w = 0;
  for (const Measurement& m : both) {
    if (m.payload->type() == PointCloud::kType) {
      ASSERT_TRUE(same_points(m, clouds[k]));
      ASSERT_TRUE(same_points(m, again[k]));
      ASSERT_FALSE(same_points(m, other[k]));
      ++k;
    } else {
      ASSERT_EQ(m.as<WheelSpeeds>().left_mps, plain[w++].as<WheelSpeeds>().left_mps);
    }
  }
  EXPECT_EQ(k, clouds.size());
}

TEST(SimulatedLidar3d, CanBeSpoiltAsTheOthers) {
  const auto all = read_all(*make(kShortDrive + ", duration_s: 4, lidar_3d: { sensor: lidar, rate_hz: 2, beams: 9,"
                                                " nan_s: [1, 2], dead_s: [3, 4] } }",
                                  mounted()));
  int spoilt = 0;
  for (const Measurement& m : all) {
    const double time = to_seconds(m.stamp.time_since_epoch());
    ASSERT_LT(time, 3.0);
    const auto& points = m.as<PointCloud>().points_m;
    ASSERT_FALSE(points.empty());
    ASSERT_EQ(points.front().hasNaN(), time >= 1.0 && time < 2.0);
    spoilt += points.front().hasNaN() ? 1 : 0;
  }
  EXPECT_EQ(spoilt, 2);
}

}  // namespace
}  // namespace waymark
