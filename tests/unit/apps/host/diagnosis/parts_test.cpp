// SPDX-License-Identifier: Apache-2.0
// What the diagnosis is made of: tracks, robust fits, registration of scans, lags.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "diagnosis/comparison.hpp"
#include "diagnosis/fit.hpp"
#include "diagnosis/lever_fit.hpp"
#include "diagnosis/path_fit.hpp"
#include "diagnosis/scan_registration.hpp"
#include "diagnosis/track.hpp"
#include "tests/unit/apps/host/diagnosis/scanned_room.hpp"

namespace waymark::host::diagnosis {
namespace {

TEST(Track, SumsARateUpBetweenItsSamples) {
  Track track;
  for (int k = 0; k <= 100; ++k) track.add_rate(0.1 * k, 0.1 * k);
  const auto change = track.change(2.0, 6.0);
  ASSERT_TRUE(change);
  EXPECT_NEAR(*change, 0.5 * (36.0 - 4.0), 0.01);
}

TEST(Track, KnowsNoChangeAcrossAGap) {
  Track track;
  for (int k = 0; k < 50; ++k) track.add_rate(0.1 * k, 1.0);
  for (int k = 0; k < 50; ++k) track.add_rate(10.0 + 0.1 * k, 1.0);
  EXPECT_TRUE(track.change(1.0, 4.0));
  EXPECT_TRUE(track.change(11.0, 14.0));
  EXPECT_FALSE(track.change(4.0, 11.0));
  EXPECT_FALSE(track.change(6.0, 8.0));
}

TEST(Track, UnwrapsAnAngle) {
  Track track;
  for (int k = 0; k <= 200; ++k) track.add_total(0.1 * k, std::remainder(0.1 * k, 2.0 * M_PI), true);
  const auto change = track.change(1.0, 19.0);
  ASSERT_TRUE(change);
  EXPECT_NEAR(*change, 18.0, 1e-6);
}

TEST(Track, AMeanHoldsForItsInterval) {
  Track track;
  for (int k = 0; k < 40; ++k) track.add_mean(0.5 * k, 0.5, k % 2 == 0 ? 1.0 : 0.0);
  const auto change = track.change(2.0, 3.0);
  ASSERT_TRUE(change);
  EXPECT_NEAR(*change, 0.5, 1e-9);
}

Rows line(double slope, int outliers, std::mt19937& dice) {
  std::normal_distribution<double> noise(0.0, 0.1);
  Rows rows(200, 2);
  for (int k = 0; k < 200; ++k) {
    const double x = std::sin(0.1 * k);
    rows.A.row(rows.count) << x, 1.0;
    rows.y(rows.count++) = k < outliers ? 5.0 : slope * x + 0.3 + noise(dice);
  }
  return rows;
}

TEST(RobustFit, FindsTheSlopeBesideOutliersWithinItsSigma) {
  std::mt19937 dice(1);
  int within = 0;
  for (int i = 0; i < 40; ++i) {
    const Fit fit = fit_rows(line(2.0, 30, dice));
    ASSERT_TRUE(fit.valid);
    within += std::abs(fit.x(0) - 2.0) < 3.0 * fit.sigma(0) ? 1 : 0;
  }
  EXPECT_GE(within, 38);
}

TEST(RobustFit, IsNoResultIfOneStretchDecides) {
  Rows rows(100, 1);
  for (int k = 0; k < 100; ++k) {
    rows.A(rows.count, 0) = k < 8 ? 1.0 : 0.0;
    rows.y(rows.count++) = k < 8 ? 3.0 : 0.0;
  }
  EXPECT_FALSE(fit_rows(rows).valid);
}

TEST(Comparison, CallsASignNotANoise) {
  std::mt19937 dice(1);
  std::normal_distribution<double> noise(0.0, 0.02);
  Track gyro;
  Track wheels;
  for (int k = 0; k < 4000; ++k) {
    const double rate = 0.5 * std::sin(0.01 * k);
    gyro.add_rate(0.05 * k, rate + noise(dice));
    wheels.add_rate(0.05 * k, -rate + noise(dice));
  }
  const Ratio ratio = compare(spans_of(wheels, 2.0, 200.0), gyro, {.tolerance = 0.1});
  EXPECT_EQ(ratio.verdict, Ratio::Verdict::differ);
  EXPECT_NEAR(ratio.value, -1.0, 0.05);
  EXPECT_GT(ratio.sigmas, 10.0);
}

TEST(Comparison, FindsALagAndItsSign) {
  Track on_time;
  Track late;
  for (int k = 0; k < 8000; ++k) {
    const double t = 0.05 * k;
    on_time.add_rate(t, std::sin(0.7 * t) + 0.5 * std::sin(1.9 * t));
    late.add_rate(t, std::sin(0.7 * (t - 0.4)) + 0.5 * std::sin(1.9 * (t - 0.4)));
  }
  const Lag lag = find_lag(spans_of(late, 0.5, 400.0), on_time, 1.0);
  ASSERT_TRUE(lag.is_known);
  EXPECT_NEAR(lag.value, 0.4, 0.02);
  EXPECT_LT(lag.sigma, 0.05);
}

/// Fixes of a boat that turns to and fro, late and noisy.
AntennaFit fit_of_late_fixes(double late_s, double noise_m, unsigned seed) {
  std::mt19937 dice(seed);
  std::normal_distribution<double> noise(0.0, noise_m);
  Track yaw;
  Track way;
  std::vector<Fix> fixes;
  Eigen::Vector2d p = Eigen::Vector2d::Zero();
  double heading = 0.0;
  for (int k = 0; k < 6000; ++k) {
    const double t = 0.05 * k;
    const double rate = 0.12 * std::sin(0.13 * t);
    yaw.add_rate(t, rate);
    way.add_rate(t, 1.4);
    if (k % 40 == 0) fixes.push_back({t + late_s, p + Eigen::Vector2d(noise(dice), noise(dice))});
    p += 0.05 * 1.4 * Eigen::Vector2d(std::cos(heading), std::sin(heading));
    heading += 0.05 * rate;
  }
  return fit_antenna(fixes, Eigen::Vector2d::Zero(), yaw, way, 0.0, 0.0, 0.0);
}

TEST(AntennaFit, ALagThatExplainsNothingIsNoise) {
  int far = 0;
  for (unsigned seed = 0; seed < 60; ++seed) {
    const AntennaFit fit = fit_of_late_fixes(0.0, 0.6, seed);
    if (!fit.lag.is_known || std::abs(fit.lag.value) < 5.0 * fit.lag.sigma || std::abs(fit.lag.value) < 0.4) continue;
    ++far;
    EXPECT_FALSE(fit.is_lag_likelier) << seed << ": " << fit.lag.value << " +- " << fit.lag.sigma;
  }
  EXPECT_GT(far, 0);
  const AntennaFit late = fit_of_late_fixes(1.0, 0.05, 1);
  EXPECT_TRUE(late.is_lag_likelier);
  EXPECT_NEAR(late.lag.value, 1.0, 0.1);
}

TEST(PathFit, ShowsTheSignOfASpeedToTheLeft) {
  std::mt19937 dice(2);
  std::normal_distribution<double> noise(0.0, 0.1);
  Track yaw;
  Track forwards;
  Track left;
  WatchedSensor receiver;
  Eigen::Vector2d p = Eigen::Vector2d::Zero();
  double heading = 0.0;
  for (int k = 0; k < 6000; ++k) {
    const double t = 0.05 * k;
    const double rate = 0.25 * std::sin(0.13 * t);
    const Eigen::Vector2d current(0.4, 0.1);
    const Eigen::Vector2d bow(std::cos(heading), std::sin(heading));
    const Eigen::Vector2d v = 1.2 * bow + current;
    yaw.add_rate(t, rate);
    forwards.add_rate(t, v.dot(bow));
    left.add_rate(t, v.dot(Eigen::Vector2d(-bow.y(), bow.x())));
    if (k % 20 == 0) receiver.fixes.push_back({t, p + Eigen::Vector2d(noise(dice), noise(dice))});
    p += 0.05 * v;
    heading += 0.05 * rate;
  }
  const PathFit right(receiver, yaw, Way(forwards, &left));
  const PathFit opposite(receiver, yaw, Way(forwards, &left, -1.0));
  EXPECT_TRUE(right.gain_over(opposite).is_clear());
  EXPECT_FALSE(opposite.gain_over(right).is_clear());
}

class Registration : public testing::TestWithParam<double> {};

TEST_P(Registration, FindsTheMotionOfTheScanner) {
  ThinScan first;
  ThinScan second;
  double largest = 100.0;
  ASSERT_TRUE(first.take(scan_from(0.0, 0.0, 0.1, GetParam()), largest));
  ASSERT_TRUE(second.take(scan_from(0.25, 0.05, 0.3, GetParam()), largest));
  const auto motion = register_scans(first, second);
  ASSERT_TRUE(motion);
  EXPECT_NEAR(motion->yaw, 0.2, 0.01);
  EXPECT_NEAR(motion->x, 0.25 * std::cos(0.1) + 0.05 * std::sin(0.1), 0.03);
  EXPECT_NEAR(motion->y, -0.25 * std::sin(0.1) + 0.05 * std::cos(0.1), 0.03);
}

INSTANTIATE_TEST_SUITE_P(BothSenses, Registration, testing::Values(1.0, -1.0));

}  // namespace
}  // namespace waymark::host::diagnosis
