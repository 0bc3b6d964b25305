// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "simulated_log.hpp"
#include "waymark/interface/map_module.hpp"

namespace waymark {
namespace {

using test::kGps;
using test::kLidar;
using test::kLoop;
using test::kShortDrive;
using test::kWheels;
using test::make;
using test::read_all;
using test::rig_with;

constexpr double kDegree = std::numbers::pi / 180.0;

/// Everything that a measurement says, exactly.
std::vector<double> numbers_of(const Measurement& m) {
  std::vector<double> numbers{static_cast<double>(m.stamp.time_since_epoch().count())};
  if (m.payload->type() == WheelSpeeds::kType) {
    numbers.insert(numbers.end(), {m.as<WheelSpeeds>().left_mps, m.as<WheelSpeeds>().right_mps});
  } else if (m.payload->type() == GnssFix::kType) {
    const Eigen::Vector3d& p = m.as<GnssFix>().p_map_antenna;
    numbers.insert(numbers.end(), {p.x(), p.y(), p.z()});
  } else {
    const auto& ranges = m.as<LaserScan>().ranges_m;
    numbers.insert(numbers.end(), ranges.begin(), ranges.end());
  }
  return numbers;
}

std::vector<std::vector<double>> numbers_of(const std::vector<Measurement>& all, std::string_view type) {
  std::vector<std::vector<double>> numbers;
  for (const Measurement& m : all) {
    if (m.payload->type() == type) numbers.push_back(numbers_of(m));
  }
  return numbers;
}

TEST(Simulator, EqualSeedsGiveEqualLogs) {
  const auto a = read_all(*make(kLoop + kWheels + kGps + kLidar + "}"));
  const auto b = read_all(*make(kLoop + kWheels + kGps + kLidar + "}"));
  ASSERT_EQ(a.size(), b.size());
  ASSERT_GT(a.size(), 2900u);
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(numbers_of(a[i]), numbers_of(b[i]));
    ASSERT_EQ(a[i].sequence, i);
  }
}

TEST(Simulator, TheSpeedSwingsBetweenCruisingSpeedAndItsShare) {
  const auto log = read_all(*make(
      "{ duration_s: 60, speed_swing: 0.4, course: { waypoints_m: [0, 0, 100, 0] }, wheels: { sensor: wheels, track_m: "
      "0.5, noise_m_per_sqrt_s: 1.0e-6 } }"));
  double slowest = 1.0;
  double fastest = 0.0;
  for (const Measurement& m : log) {
    const double speed = 0.5 * (m.as<WheelSpeeds>().left_mps + m.as<WheelSpeeds>().right_mps);
    if (m.stamp < Time(from_seconds(5.0))) continue;  // it starts from rest
    slowest = std::min(slowest, speed);
    fastest = std::max(fastest, speed);
  }
  EXPECT_NEAR(slowest, 0.6, 0.01);
  EXPECT_NEAR(fastest, 1.0, 0.01);
}

TEST(Simulator, AnotherSeedChangesTheNoiseButNotTheWorld) {
  std::string other = kLoop;
  other.replace(other.find("seed: 3"), 7, "seed: 4");
  const auto a = make(kLoop + kGps + "}");
  const auto b = make(other + kGps + "}");
  EXPECT_NE(numbers_of(a->next().value()), numbers_of(b->next().value()));
  ASSERT_EQ(a->reference()->landmarks.size(), 10u);
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_EQ(a->reference()->landmarks[i].p_map, b->reference()->landmarks[i].p_map);
  }
}

TEST(Simulator, SwitchingASensorOffLeavesTheOthersAlone) {
  const auto all = read_all(*make(kLoop + kWheels + kGps + kLidar + "}"));
  EXPECT_EQ(numbers_of(all, GnssFix::kType), numbers_of(read_all(*make(kLoop + kGps + "}")), GnssFix::kType));
  EXPECT_EQ(numbers_of(all, WheelSpeeds::kType),
            numbers_of(read_all(*make(kLoop + kWheels + "}")), WheelSpeeds::kType));
  EXPECT_EQ(numbers_of(all, LaserScan::kType), numbers_of(read_all(*make(kLoop + kLidar + "}")), LaserScan::kType));
}

TEST(Simulator, SensorsAreNotSynchronised) {
  auto all = read_all(*make(kLoop + kWheels + kGps + kLidar + "}"));
  for (std::size_t i = 1; i < all.size(); ++i) ASSERT_LT(all[i - 1].stamp, all[i].stamp);
}

TEST(Simulator, DeliversInOrderOfArrival) {
  const auto source = make(kLoop + kWheels + ", gps: { sensor: gps, delay_s: 0.5 } }");
  const auto all = read_all(*source);
  bool stamps_go_back = false;
  for (std::size_t i = 1; i < all.size(); ++i) {
    ASSERT_LE(all[i - 1].arrival, all[i].arrival);
    stamps_go_back = stamps_go_back || all[i].stamp < all[i - 1].stamp;
  }
  EXPECT_TRUE(stamps_go_back);
  EXPECT_EQ(all.back().arrival - all.back().stamp, from_seconds(0.5));
}

TEST(Simulator, NamesItsChannels) {
  const auto source = make(kLoop + kLidar + kWheels + "}");
  ASSERT_EQ(source->channels().size(), 2u);
  EXPECT_EQ(source->channels()[0].sensor, "wheels");
  EXPECT_EQ(source->channels()[0].payload_type, WheelSpeeds::kType);
  EXPECT_EQ(source->channels()[1].sensor, "lidar");
  for (const Measurement& m : read_all(*source)) {
    ASSERT_EQ(m.payload->type(), source->channels()[m.sensor].payload_type);
  }
  EXPECT_GT(source->progress(), 0.99);
}

TEST(Simulator, ReadsEveryKeyOfItsReadme) {
  const Config config = Config::parse(
      "{ seed: 1, duration_s: 5, speed_mps: 1, acceleration_mps2: 1, turn_rate_max_radps: 1, lookahead_m: 2,"
      "  lateral_slip_m_per_sqrt_s: 0.01, course: { waypoints_m: [0, 0, 5, 0, 5, 5], closed: true, laps: 2 },"
      "  landmarks: { count: 1, area_m: [-9, -9, 9, 9], radius_m: [0.1, 0.2], min_distance_m: 1,"
      "               course_clearance_m: 0.5, seed: 2 },"
      "  wheels: { sensor: wheels, rate_hz: 20, delay_s: 0, track_m: 0.5, noise_m_per_sqrt_s: 0.01,"
      "            scale_error_left: 0.01, scale_error_right: 0 },"
      "  gps: { sensor: gps, base_p_antenna_m: [0, 0, 1], sigma_m: 0.1, sigma_up_m: 0.2, correlated_sigma_m: 0.1,"
      "         correlation_time_s: 10, outages_s: [1, 2], delay_jitter_s: 1, delay_jitter_law: exponential, "
      "stamp_offset_s: 1,"
      "         dead_s: [1, 2], nan_s: [1, 2], nan_probability: 0.1, outlier_probability: 0.1, outlier_max_m: 9,"
      "         frozen_s: [1, 2], drift_s: [1, 2], drift_mps: 1, speed_sigma_mps: 0.1 },"
      "  magnetism: { disturbances_s: [1, 2], disturbance_t: [1e-6, 0, 0], disturbance_frame: map },"
      "  lidar: { sensor: lidar, range_max_m: 20, start_deg: -90, step_deg: 1, beams: 181, sigma_m: 0.01,"
      "           sweep_s: 0.1 } }");
  PluginLoader({WAYMARK_PLUGIN_DIR}).create<Source>("simulator", config, rig_with({}));
  EXPECT_NO_THROW(config.reject_unread());
}

TEST(Simulator, AnExactOdometerReproducesTheTrajectory) {
  // One sample per step of the truth: the twist is constant in between.
  const auto source =
      make(kLoop + ", wheels: { sensor: wheels, track_m: 0.4, rate_hz: 200, noise_m_per_sqrt_s: 1e-12 } }");
  const auto& truth = source->reference()->trajectory;
  Pose pose = truth.front().T_map_base;
  std::size_t compared = 0;
  std::size_t next = 0;
  while (const auto m = source->next()) {
    if (next < truth.size() && truth[next].stamp == m->stamp) {
      ASSERT_LT((truth[next].T_map_base.p - pose.p).norm(), 1e-6);
      ASSERT_LT(std::abs(so3::wrap(truth[next].T_map_base.yaw() - pose.yaw())), 1e-6);
      ++compared;
      ++next;
    }
    const auto& speeds = m->as<WheelSpeeds>();
    MotionWindow motion;
    motion.v_base.x() = 0.5 * (speeds.left_mps + speeds.right_mps);
    motion.w_base.z() = (speeds.right_mps - speeds.left_mps) / 0.4;
    pose = pose * motion.relative(0.005);
  }
  EXPECT_EQ(compared, truth.size());
}

TEST(Simulator, TheTruthIsTheSameBetweenItsSteps) {
  // 130 Hz falls between the steps; a straight drive at constant speed shows any error of the interpolation.
  const auto source = make(
      "{ duration_s: 20, acceleration_mps2: 1000, course: { waypoints_m: [0, 0, 100, 0] },"
      "  gps: { sensor: gps, rate_hz: 130, sigma_m: 1e-9 } }");
  for (const Measurement& m : read_all(*source)) {
    ASSERT_NEAR(m.as<GnssFix>().p_map_antenna.x(), to_seconds(m.stamp.time_since_epoch()), 1e-6);
  }
}

TEST(Simulator, StartsOnTheFirstWayPointTowardsTheSecond) {
  const auto source = make("{ duration_s: 1, course: { waypoints_m: [2, 3, 2, 9] }" + kWheels + "}");
  const auto& start = source->reference()->trajectory.front();
  EXPECT_EQ(start.stamp, Time{});
  EXPECT_TRUE(start.has_yaw);
  EXPECT_LT((start.T_map_base.p - Eigen::Vector3d(2.0, 3.0, 0.0)).norm(), 1e-12);
  EXPECT_NEAR(start.T_map_base.yaw(), std::numbers::pi / 2, 1e-12);
}

TEST(Simulator, FollowsTheCourseAndStopsAtItsEnd) {
  const auto source =
      make("{ duration_s: 150, course: { waypoints_m: [0, 0, 20, 0, 20, 12, 0, 12], laps: 2 }" + kWheels + "}");
  const auto& truth = source->reference()->trajectory;
  double x_max = 0.0;
  double y_max = 0.0;
  double driven = 0.0;
  for (std::size_t i = 1; i < truth.size(); ++i) {
    const Eigen::Vector3d& p = truth[i].T_map_base.p;
    // Distance from the rectangle's outline: corners are cut, by less than the look-ahead of 2 m.
    const double inside = std::min({p.x(), 20.0 - p.x(), p.y(), 12.0 - p.y()});
    ASSERT_LT(std::abs(inside), 1.0) << "at " << p.transpose();
    x_max = std::max(x_max, p.x());
    y_max = std::max(y_max, p.y());
    const double step = (p - truth[i - 1].T_map_base.p).norm();
    ASSERT_LT(step, 0.05 * 1.0 + 1e-9);
    driven += step;
  }
  EXPECT_NEAR(x_max, 20.0, 0.5);
  EXPECT_NEAR(y_max, 12.0, 0.5);
  EXPECT_NEAR(driven, 128.0, 8.0);
  EXPECT_LT(truth.back().T_map_base.p.norm(), 0.5);
  EXPECT_EQ(truth.back().T_map_base.p, truth[truth.size() - 20].T_map_base.p);
}

TEST(Simulator, AnOutageHasNoFixesAndChangesNoOther) {
  const auto with =
      read_all(*make(kLoop + ", gps: { sensor: gps, correlated_sigma_m: 0.5, outages_s: [10, 20, 30, 31] } }"));
  auto without = read_all(*make(kLoop + kGps + "}"));
  const auto out = [](const Measurement& m) {
    const double t = to_seconds(m.stamp.time_since_epoch());
    return (t >= 10.0 && t < 20.0) || (t >= 30.0 && t < 31.0);
  };
  EXPECT_EQ(std::erase_if(without, out), 55u);
  EXPECT_EQ(numbers_of(with, GnssFix::kType), numbers_of(without, GnssFix::kType));
}

TEST(Simulator, ScansShowCylindersAsGeometrySays) {
  const Pose T_base_lidar = Pose::planar(0.3, 0.1, 0.5);
  const auto source = make(
      kShortDrive +
          ", duration_s: 6, landmarks: { list_m: [4, 1, 0.5, -2, 2, 0.3, 7, 1.5, 1.0] },"
          "  lidar: { sensor: lidar, sigma_m: 1e-9, start_deg: -180, step_deg: 0.5, beams: 720, range_max_m: 10 } }",
      T_base_lidar);
  const auto scan = read_all(*source).back();
  const Pose T_map_lidar = source->reference()->trajectory.back().T_map_base * T_base_lidar;
  const auto& payload = scan.as<LaserScan>();
  ASSERT_EQ(payload.ranges_m.size(), 720u);
  int hits = 0;
  for (int beam = 0; beam < 720; ++beam) {
    double expected = 11.0;  // no return
    for (const auto& landmark : source->reference()->landmarks) {
      const Eigen::Vector2d to_center = landmark.p_map - T_map_lidar.p.head<2>();
      const double d = to_center.norm();
      const double off_axis = so3::wrap(T_map_lidar.yaw() + payload.start_rad + beam * payload.step_rad -
                                        std::atan2(to_center.y(), to_center.x()));
      if (std::abs(off_axis) > std::asin(landmark.radius_m / d)) continue;
      const double across = d * std::sin(off_axis);
      expected = std::min(expected,
                          d * std::cos(off_axis) - std::sqrt(landmark.radius_m * landmark.radius_m - across * across));
    }
    if (expected < 11.0) ++hits;
    ASSERT_NEAR(payload.ranges_m[static_cast<std::size_t>(beam)], expected, 1e-5) << "beam " << beam;
  }
  EXPECT_GT(hits, 20);
  EXPECT_LT(hits, 200);
}

TEST(Simulator, WithASweepEveryBeamIsSeenFromWhereTheRobotThenWas) {
  const auto source = make(
      "{ duration_s: 4, acceleration_mps2: 1000, course: { waypoints_m: [0, 0, 20, 0] }, walls_m: [30, -50, 30, 50],"
      " lidar: { sensor: lidar, rate_hz: 5, sigma_m: 1e-9, start_deg: -30, step_deg: 1, beams: 61, sweep_s: 0.1,"
      " range_max_m: 60 } }");
  const auto all = read_all(*source);
  ASSERT_GT(all.size(), 15u);
  for (const Measurement& m : all) {
    const auto& scan = m.as<LaserScan>();
    ASSERT_NEAR(scan.beam_interval_s, 0.1 / 61.0, 1e-12);
    const double start = to_seconds(m.stamp.time_since_epoch());
    if (start > 3.9) continue;  // where it stands at the end
    for (std::size_t k = 0; k < 61; ++k) {
      const auto beam = static_cast<double>(k);
      const double ahead = static_cast<double>(scan.ranges_m[k]) * std::cos(scan.start_rad + beam * scan.step_rad);
      ASSERT_NEAR(ahead, 30.0 - (start + beam * scan.beam_interval_s), 6e-3);  // 1 m/s in steps of 5 ms
    }
  }
}

TEST(Simulator, ACylinderBeyondTheRangeIsNotSeen) {
  const auto source = make(kShortDrive +
                           ", duration_s: 6, landmarks: { list_m: [12, 0, 0.5] },"
                           "  lidar: { sensor: lidar, start_deg: 0, beams: 1, range_max_m: 10.4 } }");
  EXPECT_FLOAT_EQ(read_all(*source).back().as<LaserScan>().ranges_m[0], 11.4f);
}

TEST(Simulator, ScansKeepTheirGeometry) {
  const auto all = read_all(*make(kLoop + kLidar + "}"));
  const auto& scan = all.front().as<LaserScan>();
  EXPECT_NEAR(scan.start_rad, -135.0 * kDegree, 1e-12);
  EXPECT_NEAR(scan.step_rad, 3.0 * kDegree, 1e-12);
  EXPECT_EQ(scan.ranges_m.size(), 90u);
}

TEST(Simulator, RandomLandmarksKeepTheirDistances) {
  const auto source = make(
      "{ duration_s: 60, course: { waypoints_m: [0, 0, 12, 0, 12, 8, 0, 8] },"
      "  landmarks: { count: 40, area_m: [-5, -6, 17, 14], radius_m: [0.2, 0.4], min_distance_m: 1.5, "
      "course_clearance_m: 0.8 }" +
      kWheels + "}");
  const auto reference = source->reference();
  const auto& landmarks = reference->landmarks;
  ASSERT_EQ(landmarks.size(), 40u);
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    const Eigen::Vector2d& p = landmarks[i].p_map;
    ASSERT_TRUE(p.x() > -5.0 && p.x() < 17.0 && p.y() > -6.0 && p.y() < 14.0);
    ASSERT_TRUE(landmarks[i].radius_m > 0.2 && landmarks[i].radius_m < 0.4);
    for (std::size_t j = 0; j < i; ++j) ASSERT_GE((landmarks[j].p_map - p).norm(), 1.5);
    for (const auto& point : reference->trajectory) {
      // The path is checked at points 0.1 m apart.
      ASSERT_GE((point.T_map_base.p.head<2>() - p).norm() - landmarks[i].radius_m, 0.8 - 0.01);
    }
  }
}

TEST(Simulator, RefusesATiltedScanner) {
  const Pose tilted{so3::from_rpy(0.0, 0.1, 0.0), Eigen::Vector3d::Zero()};
  EXPECT_THROW(make(kLoop + kLidar + "}", tilted), ConfigError);
}

}  // namespace
}  // namespace waymark
