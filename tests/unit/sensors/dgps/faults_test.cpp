// SPDX-License-Identifier: Apache-2.0
// needs plugins: odometry
// Whole runs of a robot with wheels and a receiver that has a fault.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <functional>

#include "unit/core/fusion_robot.hpp"
#include "waymark/math/random.hpp"

namespace waymark {
namespace {

using namespace test;  // NOLINT(google-build-using-namespace): the robot's parts

constexpr double kSigma = 0.3;
constexpr double kSpeed = 2.0;
constexpr double kRate = 0.1;
constexpr double kEnd = 300.0;
constexpr double kSettled = 162.0;  // after the outage

Pose truth(double t) {  // a circle of 20 m
  const double yaw = kRate * t;
  return Pose::planar(kSpeed / kRate * std::sin(yaw), kSpeed / kRate * (1.0 - std::cos(yaw)), yaw);
}

/// The receiver's fix for the true position at t; nothing: no fix.
using Fault = std::function<std::optional<Eigen::Vector2d>(double t, const Eigen::Vector2d& good, Random& random)>;

std::vector<Measurement> log_with(const Fault& fault, std::uint64_t seed) {
  std::vector<Measurement> log;
  Random noise({.seed = seed, .slot = 0, .stamp = 0, .sensor = 0});
  Random faults({.seed = 12, .slot = 0, .stamp = 0, .sensor = 1});
  for (int k = 0; k < static_cast<int>(kEnd) * 20; ++k) {
    const double t = 0.05 * k;
    log.push_back(twist(t, kSpeed + 0.02 * noise.normal(), kRate + 0.01 * noise.normal()));
  }
  for (int t = 0; t < static_cast<int>(kEnd); ++t) {
    const Eigen::Vector2d p = truth(t).p.head<2>() + kSigma * Eigen::Vector2d(noise.normal(), noise.normal());
    if (const auto seen = fault(t, p, faults)) log.push_back(fix(t, seen->x(), seen->y()));
  }
  return in_order(std::move(log));
}

struct Result {
  double rms = 0.0;    ///< of the position from 20 s on
  double worst = 0.0;  ///< from 20 s on
  double last = 0.0;   ///< r.m.s. of the last 30 s
  double step = 0.0;   ///< largest step at a fix in its predicted σ, until kSettled
};

Result run(const Fault& fault, const std::string& keys = "", std::uint64_t seed = 11) {
  FusionRobot robot("initial: { x_m: 0, y_m: 0, position_sigma_m: 0.5, yaw_deg: 0, yaw_sigma_deg: 5 }\nsensors:\n" +
                    kWheels + "  - { name: gps, plugin: dgps, base_p_antenna_m: none, sigma_m: 0.3, offset_sigma_m: 0" +
                    keys + " }\n");
  robot.play(log_with(fault, seed));
  Result result;
  double sum = 0.0;
  double sum_last = 0.0;
  int count = 0;
  int count_last = 0;
  const Seen* before = nullptr;
  for (const Seen& seen : robot.seen()) {
    if (before != nullptr && before->stamp == seen.stamp && seen.sensor == 1 && seen.stamp > 20.0 &&
        seen.stamp < kSettled) {
      const Eigen::Vector2d step = (seen.belief.mean.T_map_base.p - before->belief.mean.T_map_base.p).head<2>();
      const Eigen::Matrix2d P = before->belief.P.topLeftCorner<2, 2>();
      result.step = std::max(result.step, std::sqrt(step.dot(P.inverse() * step)));
    }
    before = &seen;
    if (seen.stamp < 20.0) continue;
    const double error = (seen.belief.mean.T_map_base.p - truth(seen.stamp).p).head<2>().norm();
    result.worst = std::max(result.worst, error);
    sum += error * error;
    ++count;
    if (seen.stamp < kEnd - 30.0) continue;
    sum_last += error * error;
    ++count_last;
  }
  result.rms = std::sqrt(sum / count);
  result.last = std::sqrt(sum_last / count_last);
  return result;
}

const Fault kNone = [](double, const Eigen::Vector2d& good, Random&) { return std::optional(good); };
const std::string kUnmonitored = ", jump_sigmas: 0, frozen_distance_m: 0, drift_sigmas: 0, adaptive_noise: false";

TEST(DgpsFaults, MonitoringCostsAGoodReceiverNothing) {
  const Result plain = run(kNone, kUnmonitored);
  const Result monitored = run(kNone);
  EXPECT_LT(plain.rms, 0.35);
  EXPECT_LT(monitored.rms, 1.02 * plain.rms);
}

class DgpsOutliers : public ::testing::TestWithParam<double> {};

TEST_P(DgpsOutliers, DoNotReachTheFilter) {
  const double share = GetParam();
  const Result result = run([&](double t, const Eigen::Vector2d& good, Random& random) {
    const double angle = 6.28 * random.uniform();
    const double distance = 10.0 + 790.0 * random.uniform();
    const bool out = random.uniform() < share && t > 3.0;
    return std::optional<Eigen::Vector2d>(out ? good + distance * Eigen::Vector2d(std::cos(angle), std::sin(angle))
                                              : good);
  });
  EXPECT_LT(result.worst, 2.0);
  EXPECT_LT(result.rms, 0.5);
}

INSTANTIATE_TEST_SUITE_P(Shares, DgpsOutliers, ::testing::Values(0.01, 0.1, 0.3));

TEST(DgpsFaults, FrozenFixesDoNotHoldTheRobot) {
  Eigen::Vector2d stuck = Eigen::Vector2d::Zero();
  const Fault freeze = [&](double t, const Eigen::Vector2d& good, Random&) {
    if (t == 100.0) stuck = good;
    return std::optional(t >= 100.0 && t < 130.0 ? stuck : good);
  };
  EXPECT_LT(run(freeze).worst, 4.0);
}

TEST(DgpsFaults, AWrongStartIsFoundOut) {
  // The receiver is right and the filter's start is 60 m off, at a σ of half a metre.
  const Fault elsewhere = [](double, const Eigen::Vector2d& good, Random&) {
    return std::optional<Eigen::Vector2d>(good + Eigen::Vector2d(60.0, -40.0));
  };
  FusionRobot robot("initial: { x_m: 0, y_m: 0, position_sigma_m: 0.5, yaw_deg: 0, yaw_sigma_deg: 5 }\nsensors:\n" +
                    kWheels +
                    "  - { name: gps, plugin: dgps, base_p_antenna_m: none, sigma_m: 0.3, offset_sigma_m: 0 }\n");
  robot.play(log_with(elsewhere, 11));
  const Eigen::Vector2d end = truth(kEnd).p.head<2>() + Eigen::Vector2d(60.0, -40.0);
  EXPECT_LT((robot.pose().p.head<2>() - end).norm(), 1.5);
}

TEST(DgpsFaults, AStepOfTheReceiverThatStaysIsFollowed) {
  // So does a filter whose robot was carried away: the sensor cannot distinguish the two.
  const Fault stepped = [](double t, const Eigen::Vector2d& good, Random&) {
    return std::optional<Eigen::Vector2d>(t < 100.0 ? good : good + Eigen::Vector2d(100.0, 0.0));
  };
  EXPECT_NEAR(run(stepped).last, 100.0, 1.0);
}

TEST(DgpsFaults, AfterAnOutageFixesThatAreStillSettlingDoLessHarm) {
  // A minute without fixes; the first two that come back are 3 m off.
  const Fault outage = [](double t, const Eigen::Vector2d& good, Random&) -> std::optional<Eigen::Vector2d> {
    if (t >= 100.0 && t < 160.0) return std::nullopt;
    return t >= 160.0 && t < kSettled ? Eigen::Vector2d(good + Eigen::Vector2d(3.0, 0.0)) : good;
  };
  int better = 0;
  for (std::uint64_t seed = 1; seed <= 7; ++seed) {
    const Result soft = run(outage, "", seed);
    EXPECT_LE(soft.step, 4.0) << seed;
    better += soft.rms < run(outage, ", reacquisition_fixes: 0", seed).rms ? 1 : 0;
  }
  EXPECT_GE(better, 6) << "of 7";
}

TEST(DgpsFaults, NoiseThreeTimesTheStatedOneIsAdaptedTo) {
  const Fault noisy = [](double t, const Eigen::Vector2d& good, Random& random) {
    const Eigen::Vector2d more(random.normal(), random.normal());
    return std::optional<Eigen::Vector2d>(t < 50.0 ? good : good + 0.85 * more);
  };
  const Result fixed = run(noisy, ", adaptive_noise: false");
  const Result adapted = run(noisy);
  EXPECT_LT(adapted.rms, 0.95 * fixed.rms);
}

}  // namespace
}  // namespace waymark
