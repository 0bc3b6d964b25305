// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/calibration/standing.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace waymark::calibration {
namespace {

constexpr double kPeriod_s = 0.01;
constexpr double kDensity = 5e-4;  // [rad/√s]

/// An IMU that is moved from `moves_s` to `rests_s` and stands before and after.
std::vector<InertialSample> samples_of(double duration_s, double moves_s, double rests_s, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::vector<InertialSample> samples;
  const auto draw = [&] { return Eigen::Vector3d(normal(random), normal(random), normal(random)); };
  for (double t = 0.0; t < duration_s; t += kPeriod_s) {
    const bool moves = t >= moves_s && t < rests_s;
    InertialSample sample;
    sample.stamp = Time(from_seconds(t));
    sample.rate = Eigen::Vector3d(0.003, -0.002, 0.001) + kDensity / std::sqrt(kPeriod_s) * draw();
    sample.force = Eigen::Vector3d(0.0, 0.0, 9.81) + 0.01 * draw();
    if (moves) sample.rate.z() += std::sin(3.0 * t);
    samples.push_back(sample);
  }
  return samples;
}

TEST(CalibrationAllan, WhiteNoiseHasItsDensity) {
  int within = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    std::vector<double> values;
    for (const InertialSample& sample : samples_of(100.0, 1e9, 1e9, seed)) values.push_back(sample.rate.x());
    const std::vector<AllanPoint> points = allan_deviation(values, kPeriod_s);
    EXPECT_NEAR(points.front().tau_s, kPeriod_s, 1e-12);
    EXPECT_NEAR(points.front().deviation, kDensity / std::sqrt(kPeriod_s), 0.05 * kDensity / std::sqrt(kPeriod_s));
    const WhiteNoise noise = white_noise(points);
    EXPECT_NEAR(noise.density, kDensity, 0.2 * kDensity);
    within += std::abs(noise.density - kDensity) < 2.0 * noise.sigma ? 1 : 0;
  }
  EXPECT_GE(within, 17) << "95 % of 20; fewer than 17 have a probability of 0.3 %";
}

TEST(CalibrationAllan, ARampGrowsWithTheTime) {
  std::vector<double> values;
  for (int i = 0; i < 1000; ++i) values.push_back(0.001 * i);
  // Two means that are τ apart differ by rate · τ: σ = rate · τ / √2.
  for (const AllanPoint& point : allan_deviation(values, kPeriod_s))
    EXPECT_NEAR(point.deviation, 0.1 * point.tau_s / std::sqrt(2.0), 1e-9);
}

TEST(CalibrationAllan, TooFewSamplesHaveNone) {
  EXPECT_TRUE(allan_deviation(std::vector<double>(8, 1.0), kPeriod_s).empty());
  EXPECT_EQ(white_noise({}).density, 0.0);
}

TEST(CalibrationStanding, FindsTheLongestStretchAndItsBias) {
  const std::optional<Standing> standing = standing_of(samples_of(200.0, 30.0, 90.0), {});
  ASSERT_TRUE(standing.has_value());
  EXPECT_NEAR(standing->begin_s, 91.0, 2.0);
  EXPECT_NEAR(standing->duration_s, 108.0, 3.0);
  EXPECT_NEAR(standing->rate_hz, 100.0, 0.1);
  EXPECT_NEAR(standing->noise.density, kDensity, 0.1 * kDensity);
  for (int axis = 0; axis < 3; ++axis) {
    const double truth[] = {0.003, -0.002, 0.001};
    EXPECT_NEAR(standing->bias(axis), truth[axis], 3.0 * standing->bias_sigma(axis));
    EXPECT_LT(standing->bias_sigma(axis), 5e-4);
  }
}

TEST(CalibrationStanding, DoesNotStandWhereTheWheelsTurn) {
  std::vector<Time> moving;
  for (double t = 0.0; t < 100.0; t += 0.1) moving.push_back(Time(from_seconds(t)));
  const std::optional<Standing> standing = standing_of(samples_of(160.0, 1e9, 1e9), moving);
  ASSERT_TRUE(standing.has_value());
  EXPECT_GE(standing->begin_s, 100.0);
}

TEST(CalibrationStanding, LessThanTwentySecondsAreNone) {
  EXPECT_FALSE(standing_of(samples_of(100.0, 15.0, 85.0), {}).has_value());
  EXPECT_FALSE(standing_of({}, {}).has_value());
}

}  // namespace
}  // namespace waymark::calibration
