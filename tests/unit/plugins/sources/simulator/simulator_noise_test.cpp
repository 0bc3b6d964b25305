// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "simulated_log.hpp"

namespace waymark {
namespace {

using test::kShortDrive;
using test::kWheels;
using test::make;
using test::read_all;

struct Moments {
  double mean = 0.0;
  double variance = 0.0;
};

Moments moments(const std::vector<double>& values) {
  Moments m;
  for (const double v : values) m.mean += v / static_cast<double>(values.size());
  for (const double v : values) m.variance += (v - m.mean) * (v - m.mean) / static_cast<double>(values.size() - 1);
  return m;
}

/// The share of beams of a standing robot's scans that return something.
double share_of_returns(const std::string& lidar) {
  const auto source =
      make(kShortDrive + ", duration_s: 60, landmarks: { list_m: [6, 0, 2] }, lidar: { sensor: lidar, " +
           "range_max_m: 20, " + lidar + " } }");
  double returns = 0.0;
  double beams = 0.0;
  for (const Measurement& m : read_all(*source)) {
    for (const float range : m.as<LaserScan>().ranges_m) {
      returns += range <= 20.0f ? 1.0 : 0.0;
      beams += 1.0;
    }
  }
  return returns / beams;
}

/// Mean speed of a wheel of a robot that drives straight on at 1 m/s.
double mean_speed(const std::string& wheels, std::uint64_t seed, bool left) {
  const auto source =
      make("{ plugin: simulator, seed: " + std::to_string(seed) +
           ", duration_s: 20, speed_mps: 1, course: { waypoints_m: [0, 0, 30, 0] }, wheels: { sensor: " +
           "wheels, track_m: 0.5, noise_m_per_sqrt_s: 0.0001" + wheels + " } }");
  std::vector<double> speeds;
  for (const Measurement& m : read_all(*source)) {
    if (m.stamp < Time{from_seconds(5)} || m.stamp > Time{from_seconds(15)}) continue;
    const auto& speed = m.as<WheelSpeeds>();
    speeds.push_back(left ? speed.left_mps : speed.right_mps);
  }
  return moments(speeds).mean;
}

TEST(Simulator, WheelsHaveScaleErrorsOfTheirOwn) {
  std::vector<double> errors;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    const double left = mean_speed(", scale_error_left: 0.1, scale_error_sigma: 0.02", seed, true) - 1.1;
    const double right = mean_speed(", scale_error_sigma: 0.02", seed, false) - 1.0;
    EXPECT_NE(left, right);
    errors.insert(errors.end(), {left, right});
  }
  EXPECT_NEAR(moments(errors).mean, 0.0, 0.0055);  // 120 draws: 3 σ
  EXPECT_NEAR(std::sqrt(moments(errors).variance), 0.02, 0.004);
}

TEST(Simulator, ACylinderIsMissingAsOftenAsAsked) {
  const double always = share_of_returns("beams: 90, step_deg: 3");
  const double missing = share_of_returns("beams: 90, step_deg: 3, miss_probability: 0.4");
  EXPECT_NEAR(missing / always, 0.6, 0.1);  // 300 scans: σ 0.03
  EXPECT_EQ(share_of_returns("beams: 90, step_deg: 3, miss_probability: 1"), 0.0);
}

TEST(Simulator, ClutterStandsInOneScanOnly) {
  EXPECT_GT(share_of_returns("beams: 90, step_deg: 3, clutter_per_scan: 5"),
            share_of_returns("beams: 90, step_deg: 3"));
  const auto source =
      make(kShortDrive + ", duration_s: 20, lidar: { sensor: lidar, range_max_m: 20, clutter_per_scan: 3 } }");
  std::vector<std::vector<float>> scans;
  for (const Measurement& m : read_all(*source)) scans.push_back(m.as<LaserScan>().ranges_m);
  const auto kept = [&](std::size_t k) {  // beams of a scan that return something, and of these those that do again
    int returns = 0;
    int again = 0;
    for (std::size_t i = 0; i < scans[k].size(); ++i) {
      if (scans[k][i] > 20.0f) continue;
      ++returns;
      again += std::abs(scans[k + 1][i] - scans[k][i]) < 0.2f ? 1 : 0;
    }
    return std::pair{returns, again};
  };
  int returns = 0;
  int again = 0;
  for (std::size_t k = 0; k + 1 < scans.size(); ++k) {
    returns += kept(k).first;
    again += kept(k).second;
  }
  ASSERT_GT(returns, 100);
  EXPECT_LT(again, returns / 10);
}

TEST(Simulator, SlipMovesTheRobotSidewaysAsItsDensitySays) {
  // A course that ends before pursuit pulls back: 2 s at 1 m/s with a look-ahead of 50 m. Density 0.1 m/√s gives 0.1·√2
  // m.
  const int runs = 400;
  std::vector<double> sideways;
  for (int seed = 1; seed <= runs; ++seed) {
    const auto source =
        make("{ seed: " + std::to_string(seed) +
             ", duration_s: 2, acceleration_mps2: 1000, lookahead_m: 50, lateral_slip_m_per_sqrt_s: 0.1,"
             "  course: { waypoints_m: [0, 0, 100, 0] }" +
             kWheels + "}");
    sideways.push_back(source->reference()->trajectory.back().T_map_base.p.y());
  }
  const Moments m = moments(sideways);
  const double variance = 0.1 * 0.1 * 2.0;
  EXPECT_NEAR(m.mean, 0.0, 4.0 * std::sqrt(variance / runs));
  EXPECT_NEAR(m.variance, variance, 4.0 * variance * std::sqrt(2.0 / runs));
}

TEST(Simulator, WheelNoiseHasTheStatedDensity) {
  for (const int rate : {40, 10}) {
    const auto source = make(
        "{ duration_s: 1000, acceleration_mps2: 1000, course: { waypoints_m: [0, 0, 2000, 0] }, wheels: { sensor: "
        "wheels,"
        "  track_m: 0.5, rate_hz: " +
        std::to_string(rate) + ", noise_m_per_sqrt_s: 0.02, scale_error_left: 0.1 } }");
    std::vector<double> left;
    std::vector<double> right;
    double product = 0.0;
    for (const Measurement& m : read_all(*source)) {
      left.push_back(m.as<WheelSpeeds>().left_mps - 1.1);
      right.push_back(m.as<WheelSpeeds>().right_mps - 1.0);
      product += left.back() * right.back();
    }
    const auto n = static_cast<double>(left.size());
    const double variance = 0.02 * 0.02 * rate;
    for (const auto& wheel : {left, right}) {
      EXPECT_NEAR(moments(wheel).mean, 0.0, 4.0 * std::sqrt(variance / n));
      EXPECT_NEAR(moments(wheel).variance, variance, 4.0 * variance * std::sqrt(2.0 / n));
    }
    EXPECT_NEAR(product / n, 0.0, 4.0 * variance / std::sqrt(n));
  }
}

TEST(Simulator, SpinningWheelsTurnFasterThanTheRobotMoves) {
  const auto source = make(
      "{ duration_s: 10, acceleration_mps2: 1000, course: { waypoints_m: [0, 0, 100, 0] }, wheels: { sensor: wheels,"
      "  track_m: 0.5, noise_m_per_sqrt_s: 1e-9, scale_error_left: 0.1, spins_s: [2, 4], spin_ratio: 0.5 } }");
  for (const Measurement& m : read_all(*source)) {
    const double time = to_seconds(m.stamp.time_since_epoch());
    const double spin = time >= 2.0 && time < 4.0 ? 1.5 : 1.0;
    ASSERT_NEAR(m.as<WheelSpeeds>().left_mps, 1.1 * spin, 1e-6) << time;
    ASSERT_NEAR(m.as<WheelSpeeds>().right_mps, spin, 1e-6) << time;
  }
  EXPECT_NEAR(source->reference()->trajectory.back().T_map_base.p.x(), 10.0, 0.1);  // the robot does not notice
}

TEST(Simulator, AStandingWheelSaysZero) {
  const auto all = read_all(*make(kShortDrive + ", duration_s: 10, wheels: { sensor: wheels, track_m: 0.5 } }"));
  EXPECT_NE(all[40].as<WheelSpeeds>().left_mps, 0.0);
  EXPECT_EQ(all.back().as<WheelSpeeds>().left_mps, 0.0);
  EXPECT_EQ(all.back().as<WheelSpeeds>().right_mps, 0.0);
}

TEST(Simulator, WhiteGpsNoiseHasTheStatedSigma) {
  const auto source =
      make(kShortDrive + ", duration_s: 2000, gps: { sensor: gps, sigma_m: 0.3, base_p_antenna_m: [0.2, 0.1, 1.5] } }");
  const Eigen::Vector3d antenna = source->reference()->trajectory.back().T_map_base * Eigen::Vector3d(0.2, 0.1, 1.5);
  std::vector<double> errors[3];
  for (const Measurement& m : read_all(*source)) {
    if (m.stamp < Time{from_seconds(10.0)}) continue;
    const auto& fix = m.as<GnssFix>();
    for (int axis = 0; axis < 3; ++axis) errors[axis].push_back(fix.p_map_antenna[axis] - antenna[axis]);
    ASSERT_EQ(fix.sigma_horizontal_m, 0.3);
    ASSERT_EQ(fix.sigma_vertical_m, 0.6);
  }
  const auto n = static_cast<double>(errors[0].size());
  for (int axis = 0; axis < 3; ++axis) {
    const double variance = axis < 2 ? 0.09 : 0.36;
    EXPECT_NEAR(moments(errors[axis]).mean, 0.0, 4.0 * std::sqrt(variance / n));
    EXPECT_NEAR(moments(errors[axis]).variance, variance, 4.0 * variance * std::sqrt(2.0 / n));
  }
}

TEST(Simulator, TheGpsOffsetIsAGaussMarkovProcess) {
  const auto source = make(kShortDrive +
                           ", duration_s: 20000, gps: { sensor: gps, sigma_m: 1e-6, correlated_sigma_m: 0.5,"
                           "  correlation_time_s: 2, rate_hz: 5 } }");
  const Eigen::Vector3d truth = source->reference()->trajectory.back().T_map_base.p;
  std::vector<double> east;
  for (const Measurement& m : read_all(*source)) {
    if (m.stamp >= Time{from_seconds(10.0)}) east.push_back(m.as<GnssFix>().p_map_antenna.x() - truth.x());
  }
  double lagged = 0.0;
  for (std::size_t i = 1; i < east.size(); ++i) lagged += east[i] * east[i - 1] / static_cast<double>(east.size() - 1);
  const double variance = moments(east).variance;
  // Squares of the process decorrelate in half its time: 20000 s / 2 s independent values.
  EXPECT_NEAR(variance, 0.25, 5.0 * 0.25 * std::sqrt(2.0 / 10000.0));
  const double phi = std::exp(-0.2 / 2.0);
  EXPECT_NEAR(lagged / variance, phi, 5.0 * std::sqrt((1.0 - phi * phi) / static_cast<double>(east.size())));
}

TEST(Simulator, RangeNoiseHasTheStatedSigma) {
  const auto source = make(kShortDrive +
                           ", duration_s: 1000, landmarks: { list_m: [6, 0, 0.5] },"
                           "  lidar: { sensor: lidar, start_deg: 0, beams: 1, sigma_m: 0.05 } }");
  const double truth = 5.5 - source->reference()->trajectory.back().T_map_base.p.x();
  std::vector<double> errors;
  for (const Measurement& m : read_all(*source)) {
    if (m.stamp >= Time{from_seconds(10.0)})
      errors.push_back(static_cast<double>(m.as<LaserScan>().ranges_m[0]) - truth);
  }
  const auto n = static_cast<double>(errors.size());
  EXPECT_NEAR(moments(errors).mean, 0.0, 4.0 * 0.05 / std::sqrt(n));
  EXPECT_NEAR(moments(errors).variance, 0.0025, 4.0 * 0.0025 * std::sqrt(2.0 / n));
}

}  // namespace
}  // namespace waymark
