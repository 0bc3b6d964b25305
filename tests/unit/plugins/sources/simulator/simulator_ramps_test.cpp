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

using test::make;
using test::make_with;
using test::read_all;

constexpr double kGravity = 9.80665;
constexpr double kImuRate = 1000.0;   // [Hz], as in kImu
constexpr double kSlope = 2.0 / 9.5;  // of the ramp's straight part

/// Along y = 0 up the ramp, round on the floor and down again, then back below the floor along y = 6.
const std::string kTwoFloors =
    "{ duration_s: 110, seed: 3, lookahead_m: 2,"
    "  course: { waypoints_m: [0, 0, 17, 0, 17, 4, 14, 4, 14, 0, -2, 0, -2, 6, 17, 6], closed: false },"
    "  ramps_m: [2, 0, 0, 12, 0, 2, 3], floors: [ { area_m: [12, -4, 20, 8], height_m: 2 } ]";
const std::string kUneven =
    "{ duration_s: 40, seed: 3, lookahead_m: 2, bumps: { height_m: 0.05, length_m: 2.5 },"
    "  course: { waypoints_m: [0, 0, 17, 0, 17, 4, 14, 4, 14, 0, 0, 0], closed: false },"
    "  ramps_m: [2, 0, 0, 12, 0, 2, 3], floors: [ { area_m: [12, -4, 20, 8], height_m: 2 } ]";
const std::string kWheels = ", wheels: { sensor: wheels, track_m: 0.5, rate_hz: 200, noise_m_per_sqrt_s: 1e-12 } }";
const std::string kImu =
    ", imu: { sensor: imu, rate_hz: 1000, gyroscope_noise_radps_per_sqrt_hz: 0, gyroscope_bias_sigma_radps: 0,"
    " gyroscope_bias_walk_radps_per_sqrt_s: 0, accelerometer_noise_mps2_per_sqrt_hz: 0,"
    " accelerometer_bias_sigma_mps2: 0, accelerometer_bias_walk_mps2_per_sqrt_s: 0, magnetometer_noise_t: 0 } }";
/// The robot climbs to x = 7 on the ramp, 1 m high, and stands there.
const std::string kOnTheRamp =
    "{ duration_s: 14, lookahead_m: 2, course: { waypoints_m: [0, 0, 7, 0] }, ramps_m: [2, 0, 0, 12, 0, 2, 3]";

std::shared_ptr<Source> with_imu(const std::string& robot, const Pose& T_base_imu = {}) {
  return make_with(Rig({{.name = "imu", .payload = "", .T_base_sensor = T_base_imu}}), robot + kImu);
}

TEST(SimulatorRamps, TheHeightIsThatOfTheWayByWhichTheRobotCame) {
  const auto source = make(kTwoFloors + kWheels);
  double highest = 0.0;
  double below_the_floor = 0.0;
  double before = 0.0;
  for (const Reference::Point& pose : source->reference()->trajectory) {
    const Eigen::Vector3d& p = pose.T_map_base.p;
    ASSERT_LT(std::abs(p.z() - before), 0.05 * kSlope + 1e-9) << "a step";
    before = p.z();
    highest = std::max(highest, p.z());
    const bool on_the_ramp = std::abs(p.y()) < 1.5 && p.x() > 2.5 && p.x() < 11.5;
    if (on_the_ramp) {
      ASSERT_NEAR(p.z(), kSlope * (p.x() - 2.25), 1e-9);
      // On an incline the x axis points uphill as far as the robot does.
      const Eigen::Vector3d up = pose.T_map_base.q * Eigen::Vector3d::UnitZ();
      ASSERT_LT((up - Eigen::Vector3d(-kSlope, 0.0, 1.0).normalized()).norm(), 1e-9);
    }
    if (p.x() > 12.1 && p.y() > 5.0) {
      ASSERT_EQ(p.z(), 0.0);
      below_the_floor = std::max(below_the_floor, p.x());
    }
    if (p.x() > 12.1 && p.y() < 4.8) {
      ASSERT_NEAR(p.z(), 2.0, 1e-12);
    }
  }
  EXPECT_NEAR(highest, 2.0, 1e-12);
  EXPECT_GT(below_the_floor, 16.0);
}

TEST(SimulatorRamps, TheRobotStandsUntilItStarts) {
  const std::string late = kOnTheRamp;
  const auto source = make(late + ", start_s: 2" + kWheels);
  const auto at_once = make(late + kWheels);
  const auto& trajectory = source->reference()->trajectory;
  const auto& earlier = at_once->reference()->trajectory;
  for (std::size_t i = 0; i <= 40; ++i) ASSERT_EQ(trajectory[i].T_map_base.p, trajectory[0].T_map_base.p) << i;
  for (std::size_t i = 40; i < trajectory.size(); ++i)
    ASSERT_LT((trajectory[i].T_map_base.p - earlier[i - 40].T_map_base.p).norm(), 1e-9) << i;
}

TEST(SimulatorRamps, TheBaseMovesInTheSurfaceOnly) {
  const auto source = make(kUneven + kWheels);
  const auto& trajectory = source->reference()->trajectory;
  double steepest = 0.0;
  for (std::size_t i = 2; i < trajectory.size(); ++i) {
    const Pose& middle = trajectory[i - 1].T_map_base;
    const Eigen::Vector3d v =
        middle.q.conjugate() * (trajectory[i].T_map_base.p - trajectory[i - 2].T_map_base.p) / 0.1;
    // Where the slope begins, it changes within the difference.
    ASSERT_NEAR(v.z(), 0.0, 0.012) << i;
    ASSERT_NEAR(v.y(), 0.0, 0.012) << i;
    steepest = std::max(steepest, std::abs(so3::to_rpy(middle.q).x()));
  }
  EXPECT_GT(steepest, 0.05) << "it rolls";
}

TEST(SimulatorRamps, WheelsAddUpToTheWayAlongTheSurface) {
  for (const std::string& world : {kTwoFloors, kUneven}) {
    const auto source = make(world + kWheels);
    const auto& trajectory = source->reference()->trajectory;
    double way = 0.0;
    double in_the_plan = 0.0;
    for (std::size_t i = 1; i < trajectory.size(); ++i) {
      const Eigen::Vector3d step = trajectory[i].T_map_base.p - trajectory[i - 1].T_map_base.p;
      way += step.norm();
      in_the_plan += step.head<2>().norm();
    }
    double measured = 0.0;
    for (const Measurement& m : read_all(*source)) {
      const auto& wheels = m.as<WheelSpeeds>();
      measured += 0.5 * (wheels.left_mps + wheels.right_mps) / 200.0;
    }
    EXPECT_NEAR(measured, way, 0.002 * way);
    EXPECT_GT(way, in_the_plan + 0.2);
    EXPECT_GT(measured, in_the_plan + 0.15);
  }
}

/// How far strapdown navigation strays that starts from the first reference pose, at rest.
struct Strayed {
  double turn_rad = 0.0;
  double place_m = 0.0;
  double pitch_rad = 0.0;  ///< the largest that there was
};

Strayed navigate(const std::string& robot) {
  const auto source = with_imu(robot);
  const auto& trajectory = source->reference()->trajectory;
  Pose pose = trajectory.front().T_map_base;
  Eigen::Vector3d v = Eigen::Vector3d::Zero();
  double now_s = 0.0;
  std::size_t next = 1;
  Strayed worst;
  for (const Measurement& m : read_all(*source)) {
    const auto& imu = m.as<ImuSample>();
    // A sample stands for the time around it, up to half way to the next.
    const double until_s = to_seconds(m.stamp.time_since_epoch()) + 0.5 / kImuRate;
    for (; next < trajectory.size(); ++next) {
      const Pose& truth = trajectory[next].T_map_base;
      const double ahead_s = to_seconds(trajectory[next].stamp.time_since_epoch()) - now_s;
      if (now_s + ahead_s > until_s) break;
      const Eigen::Quaterniond q = pose.q * so3::exp(imu.w_sensor * ahead_s);
      worst.turn_rad = std::max(worst.turn_rad, so3::log(q.conjugate() * truth.q).norm());
      worst.place_m = std::max(worst.place_m, (pose.p + v * ahead_s - truth.p).norm());
      worst.pitch_rad = std::max(worst.pitch_rad, std::abs(so3::to_rpy(truth.q).y()));
    }
    const double dt = until_s - now_s;
    now_s = until_s;
    const Eigen::Quaterniond middle = pose.q * so3::exp(0.5 * dt * imu.w_sensor);
    const Eigen::Vector3d a = middle * imu.f_sensor - Eigen::Vector3d(0.0, 0.0, kGravity);
    pose.p += v * dt + 0.5 * dt * dt * a;
    v += a * dt;
    pose.q = (pose.q * so3::exp(imu.w_sensor * dt)).normalized();
  }
  return worst;
}

TEST(SimulatorRamps, TheGyroscopeLeadsToTheTrueAttitude) {
  // Where a ramp's slope begins and ends, the pitch rate jumps between two samples.
  const Strayed worst = navigate(kUneven);
  EXPECT_LT(worst.turn_rad, 0.005);
  EXPECT_GT(worst.pitch_rad, 0.2);
}

TEST(SimulatorRamps, TheAccelerometerLeadsToTheTruePlace) {
  const Strayed worst = navigate(
      "{ duration_s: 20, seed: 3, lookahead_m: 2, bumps: { height_m: 0.05, length_m: 2.5 },"
      "  course: { waypoints_m: [0, 0, 8, 0, 8, 8] }");
  EXPECT_LT(worst.turn_rad, 1e-3);
  // A tilt that is wrong by 0.1 degrees would lead 3.4 m astray.
  EXPECT_LT(worst.place_m, 0.4);
  EXPECT_GT(worst.pitch_rad, 0.1);
}

TEST(SimulatorRamps, AtRestOnARampGravityIsTilted) {
  const Pose T_base_imu{so3::from_rpy(0.1, -0.2, 0.3), {0.4, 0.1, 0.2}};
  const auto all = read_all(*with_imu(kOnTheRamp, T_base_imu));
  const auto& imu = all.back().as<ImuSample>();
  const Eigen::Vector3d f_base = T_base_imu.q * imu.f_sensor;
  const double angle = std::atan(kSlope);
  EXPECT_LT((f_base - kGravity * Eigen::Vector3d(std::sin(angle), 0.0, std::cos(angle))).norm(), 1e-9);
  EXPECT_LT(imu.w_sensor.norm(), 1e-12);
  // North lies across the ramp, down into it.
  const Eigen::Vector3d m_base = T_base_imu.q * imu.m_sensor;
  const Eigen::Vector3d expected(-4.4e-5 * std::sin(angle), 2e-5, -4.4e-5 * std::cos(angle));
  EXPECT_LT((m_base - expected).norm(), 1e-12);
}

TEST(SimulatorRamps, GpsAndBeaconsMeasureTheHeight) {
  const auto fix = read_all(*make(kOnTheRamp + ", gps: { sensor: gps, sigma_m: 1e-6, base_p_antenna_m: [0, 0, 1] } }"));
  const double angle = std::atan(kSlope);
  const Eigen::Vector3d antenna(7.0 - std::sin(angle), 0.0, 1.0 + std::cos(angle));
  EXPECT_LT((fix.back().as<GnssFix>().p_map_antenna - antenna).norm(), 2e-3);
  const auto ranges = read_all(*make(kOnTheRamp + ", beacons: { sensor: gps, places_m: [7, 0, 5], sigma_m: 1e-6 } }"));
  EXPECT_NEAR(ranges.back().as<Ranges>().ranges.front().range_m, 4.0, 1e-3);
}

TEST(SimulatorRamps, ScannersLeanWithTheRobot) {
  // Level in a robot that looks uphill, the beam ahead runs along the ramp, to the wall; that backwards meets the
  // ground where the scanner's plane does.
  const std::string walls = ", walls_m: [11.8, -5, 11.8, 5], wall_height_m: 9";
  const auto scan = read_all(*make(kOnTheRamp + walls +
                                       ", lidar: { sensor: lidar, sigma_m: 1e-9, range_max_m: 60, "
                                       "start_deg: 0, step_deg: 90, beams: 4 } }",
                                   Pose{Eigen::Quaterniond::Identity(), {0.0, 0.0, 0.5}}));
  const auto& ranges = scan.back().as<LaserScan>().ranges_m;
  const double angle = std::atan(kSlope);
  const double x = 7.0 - 0.5 * std::sin(angle);
  const double z = 1.0 + 0.5 * std::cos(angle);
  EXPECT_NEAR(ranges[0], (11.8 - x) / std::cos(angle), 2e-3);
  EXPECT_NEAR(ranges[2], z / std::sin(angle), 2e-3);
  EXPECT_GT(ranges[1], 60.0F);
}

/// Points of all clouds in the map.
std::vector<Eigen::Vector3d> cloud_points(const std::string& robot) {
  const auto source = make(robot +
                               ", lidar_3d: { sensor: lidar, rate_hz: 2, rings: 8, elevation_min_deg: -40, "
                               "elevation_max_deg: 40, step_deg: 10, beams: 36, sigma_m: 1e-9 } }",
                           Pose{Eigen::Quaterniond::Identity(), {0.0, 0.0, 0.8}});
  const auto reference = source->reference();
  std::vector<Eigen::Vector3d> points;
  for (const Measurement& m : read_all(*source)) {
    // 2 Hz with a phase of 0.43: the stamps lie between two reference poses, 15 ms after the first.
    const auto next = std::ranges::lower_bound(reference->trajectory, m.stamp, {}, &Reference::Point::stamp);
    if (next == reference->trajectory.begin() || next == reference->trajectory.end()) continue;
    const Reference::Point& a = *(next - 1);
    const double share = to_seconds(m.stamp - a.stamp) / to_seconds(next->stamp - a.stamp);
    const Pose T_map_base{a.T_map_base.q.slerp(share, next->T_map_base.q),
                          (1.0 - share) * a.T_map_base.p + share * next->T_map_base.p};
    for (const Eigen::Vector3f& p : m.as<PointCloud>().points_m)
      points.push_back(T_map_base * (p.cast<double>() + Eigen::Vector3d(0.0, 0.0, 0.8)));
  }
  return points;
}

TEST(SimulatorRamps, CloudsShowRampAndFloorFromBothSides) {
  int on_ramp = 0;
  int on_floor = 0;
  int under_floor = 0;
  for (const Eigen::Vector3d& p : cloud_points(kTwoFloors)) {
    const bool over_ramp = std::abs(p.y()) < 1.49 && p.x() > 2.6 && p.x() < 11.4;
    const bool over_floor = p.x() > 12.1 && p.x() < 19.9 && p.y() > -3.9 && p.y() < 7.9;
    if (over_ramp) {
      ASSERT_NEAR(p.z(), kSlope * (p.x() - 2.25), 0.03);
      ++on_ramp;
    } else if (over_floor && p.z() > 0.1) {
      const bool is_above = p.z() > 1.9;
      ASSERT_NEAR(p.z(), is_above ? 2.0 : 1.8, 0.03);
      ++(is_above ? on_floor : under_floor);
    }
  }
  EXPECT_GT(on_ramp, 300);
  EXPECT_GT(on_floor, 300);
  EXPECT_GT(under_floor, 100);
}

TEST(SimulatorRamps, WalkwaysAreFurnishedOnTheirOwnFloor) {
  // A crate on the upper floor stands above the way below it; and one below stands under the way above.
  const std::string furnished =
      kTwoFloors.substr(0, kTwoFloors.find("floors:")) +
      "boxes_m: [15.5, 2, 1, 1, 1.5, 17, 2, 0.4, 0.4, 1],"
      "floors: [ { area_m: [12, -4, 20, 8], height_m: 2, boxes_m: [15, 6, 1, 1, 0.7], walls_m: [12, 7, 20, 7] } ]";
  int crate = 0;
  for (const Eigen::Vector3d& p : cloud_points(furnished)) {
    if ((p.head<2>() - Eigen::Vector2d(15, 6)).cwiseAbs().maxCoeff() > 0.51 || p.z() < 2.05) continue;
    ASSERT_LT(p.z(), 2.7 + 0.01);
    ++crate;
  }
  EXPECT_GT(crate, 5);
}

TEST(SimulatorRamps, TheSameWorldWithoutRampsStaysAsItWas) {
  const std::string level = "{ duration_s: 20, course: { waypoints_m: [0, 0, 12, 0, 12, 8] }, seed: 3";
  const std::string far_away = ", ramps_m: [100, 0, 0, 110, 0, 2, 3]";
  const auto a = read_all(*with_imu(level));
  const auto b = read_all(*with_imu(level + far_away));
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_LT((a[i].as<ImuSample>().w_sensor - b[i].as<ImuSample>().w_sensor).norm(), 1e-12);
    ASSERT_LT((a[i].as<ImuSample>().f_sensor - b[i].as<ImuSample>().f_sensor).norm(), 1e-9);
  }
}

TEST(SimulatorRamps, ImpossibleGroundIsRefused) {
  const auto message = [](const std::string& world) -> std::string {
    try {
      make("{ duration_s: 20, course: { waypoints_m: [0, 0, 12, 0] }, " + world + kWheels);
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "accepted";
  };
  const auto refuses = [&](const std::string& world, const std::string& part) {
    EXPECT_NE(message(world).find(part), std::string::npos) << message(world);
  };
  refuses("ramps_m: [2, 0, 0, 12, 0, 2]", "6 numbers");
  refuses("ramps_m: [2, 0, 0, 12, 0, 2, 0]", "ramp 1 has width 0");
  refuses("ramps_m: [2, 0, 0, 2.9, 0, 0.2, 2]", "twice ramp_rounding_m = 0.5");
  refuses("ramps_m: [2, 0, 0, 4, 0, 2, 2]", "slope");
  refuses("ramps_m: [2, 0, -1, 12, 0, 2, 2]", "below the ground");
  refuses("ramps_m: [2, 0, 0, 8, 0, 2, 3]", "course: at (8.0");
  refuses("ramps_m: [2, 0, 0, 8, 0, 2, 3]", "drives over an edge, from 2.00 m down to 0.00 m");
  refuses("ramps_m: [8, 0, 0, 2, 0, 2, 3]", "runs into the side of a ramp or floor");
  refuses("floors: [ { area_m: [5, 0, 4, 9], height_m: 2 } ]", "area_m");
  refuses("floors: [ { area_m: [4, 0, 5, 9], height_m: 0 } ]", "height_m");
  refuses("floors: [ { area_m: [4, 0, 5, 9], height_m: 2, thickness_m: 3 } ]", "thickness_m");
  refuses("floors: [ { area_m: [4, -1, 5, 1], height_m: 0.5, thickness_m: 0.4995 } ]", "runs into the side");
  refuses("bumps: { length_m: 2 }", "height_m");
  refuses("bumps: { height_m: 0.3, length_m: 2 }", "a tenth of length_m");
}

}  // namespace
}  // namespace waymark
