// SPDX-License-Identifier: Apache-2.0
#include "particles/resampling.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "unit/core/beliefs.hpp"

namespace waymark {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::vector<double> random_log_weights(int count, Random& random) {
  std::vector<double> log_weights(static_cast<std::size_t>(count));
  for (double& w : log_weights) w = 2.0 * random.normal();
  particles::normalize_log_weights(log_weights);
  return log_weights;
}

std::vector<int> children(std::span<const double> log_weights, double u) {
  std::vector<int> count(log_weights.size(), 0);
  for (const int ancestor : particles::systematic_resample(log_weights, u)) ++count[static_cast<std::size_t>(ancestor)];
  return count;
}

TEST(NormalizeLogWeights, SumsToOneWithoutOverflow) {
  std::vector<double> w = {1000.0, 1000.0 + std::log(3.0)};
  EXPECT_TRUE(particles::normalize_log_weights(w));
  EXPECT_NEAR(std::exp(w[0]), 0.25, 1e-12);
  EXPECT_NEAR(std::exp(w[1]), 0.75, 1e-12);
}

TEST(NormalizeLogWeights, KeepsWhatIsImpossibleImpossible) {
  std::vector<double> w = {-kInfinity, -3.0, -3.0};
  EXPECT_TRUE(particles::normalize_log_weights(w));
  EXPECT_EQ(w[0], -kInfinity);
  EXPECT_NEAR(w[1], std::log(0.5), 1e-15);
}

TEST(NormalizeLogWeights, BecomesEqualIfNothingExplainsTheData) {
  for (const double bad : {-kInfinity, std::nan("")}) {
    std::vector<double> w(4, bad);
    EXPECT_FALSE(particles::normalize_log_weights(w));
    for (const double x : w) EXPECT_DOUBLE_EQ(x, std::log(0.25));
  }
}

TEST(EffectiveSampleSize, LiesBetweenOneAndTheNumber) {
  EXPECT_DOUBLE_EQ(particles::effective_sample_size(std::vector<double>(10, std::log(0.1))), 10.0);
  EXPECT_DOUBLE_EQ(particles::effective_sample_size(std::vector<double>{0.0, -kInfinity, -kInfinity}), 1.0);
  EXPECT_NEAR(particles::effective_sample_size(std::vector<double>{std::log(0.5), std::log(0.5), -kInfinity}), 2.0,
              1e-12);
}

TEST(SystematicResample, GivesFloorOrCeilingOfTheExpectedChildren) {
  Random random = test::stream(5);
  for (int trial = 0; trial < 300; ++trial) {
    const int count = 1 + trial % 60;
    const auto w = random_log_weights(count, random);
    const auto kids = children(w, random.uniform());
    for (int i = 0; i < count; ++i) {
      const double expected = count * std::exp(w[static_cast<std::size_t>(i)]);
      EXPECT_GE(kids[static_cast<std::size_t>(i)], std::floor(expected - 1e-9));
      EXPECT_LE(kids[static_cast<std::size_t>(i)], std::ceil(expected + 1e-9));
    }
  }
}

TEST(SystematicResample, AncestorsAscend) {
  Random random = test::stream(6);
  const auto w = random_log_weights(50, random);
  const auto ancestors = particles::systematic_resample(w, 0.3);
  EXPECT_EQ(ancestors.size(), w.size());
  EXPECT_TRUE(std::is_sorted(ancestors.begin(), ancestors.end()));
}

// Over a grid of u, the mean number of children is M w up to the grid's spacing: each of the two ends of a particle's
// interval falls into one cell of the grid.
TEST(SystematicResample, IsUnbiasedOverItsRandomNumber) {
  constexpr int kGrid = 2000;
  Random random = test::stream(7);
  const auto w = random_log_weights(7, random);
  std::vector<double> mean(w.size(), 0.0);
  for (int k = 0; k < kGrid; ++k) {
    const auto kids = children(w, (k + 0.5) / kGrid);
    for (std::size_t i = 0; i < w.size(); ++i) mean[i] += static_cast<double>(kids[i]) / kGrid;
  }
  for (std::size_t i = 0; i < w.size(); ++i) EXPECT_NEAR(mean[i], 7.0 * std::exp(w[i]), 2.0 / kGrid);
}

TEST(SystematicResample, EqualWeightsKeepEveryone) {
  const std::vector<double> w(8, std::log(1.0 / 8.0));
  for (const double u : {0.1, 0.5, 0.9}) EXPECT_EQ(children(w, u), std::vector<int>(8, 1));
}

TEST(SystematicResample, OneParticleTakesAll) {
  EXPECT_EQ(children(std::vector<double>{-kInfinity, -kInfinity, 0.0, -kInfinity}, 0.7),
            (std::vector<int>{0, 0, 4, 0}));
  EXPECT_EQ(children(std::vector<double>{0.0}, 0.999), std::vector<int>{1});
}

TEST(SystematicResample, WhatIsImpossibleNeverHasChildren) {
  // With the smallest and the largest u, and weights whose sum rounds below one.
  for (int possible = 1; possible < 40; ++possible) {
    std::vector<double> w(static_cast<std::size_t>(possible) + 2, 0.0);
    w.front() = -kInfinity;
    w.back() = -kInfinity;
    particles::normalize_log_weights(w);
    for (const double u : {0x1p-53, 0.5, 1.0 - 0x1p-53}) {
      const auto kids = children(w, u);
      EXPECT_EQ(kids.front(), 0) << possible << " " << u;
      EXPECT_EQ(kids.back(), 0) << possible << " " << u;
    }
  }
}

}  // namespace
}  // namespace waymark
