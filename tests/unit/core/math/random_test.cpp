// SPDX-License-Identifier: Apache-2.0
#include "waymark/math/random.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <vector>

#include "math/philox.hpp"

namespace waymark {
namespace {

using Counter = std::array<std::uint32_t, 4>;

// The known answers of Random123 (D. E. Shaw Research), philox4x32-10.
TEST(Philox, GivesTheKnownAnswers) {
  EXPECT_EQ(philox({0, 0, 0, 0}, {0, 0}), (Counter{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
  EXPECT_EQ(philox({0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff}, {0xffffffff, 0xffffffff}),
            (Counter{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
  EXPECT_EQ(philox({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}),
            (Counter{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

TEST(SplitMix, GivesTheKnownAnswers) {
  EXPECT_EQ(split_mix(0), 0xe220a8397b1dcdafu);
  EXPECT_EQ(split_mix(0x9E3779B97F4A7C15u), 0x6e789e6aa1b965f4u);
}

std::vector<double> draws(const Random::Key& key, int count) {
  Random random(key);
  std::vector<double> values;
  for (int i = 0; i < count; ++i) values.push_back(random.uniform());
  return values;
}

TEST(Random, IsAFunctionOfItsKey) {
  const Random::Key key{.seed = 1, .slot = 2, .stamp = 3, .sensor = 4};
  EXPECT_EQ(draws(key, 100), draws(key, 100));
}

TEST(Random, EveryPartOfTheKeyMatters) {
  const std::int64_t far = std::int64_t{1} << 40;
  std::set<double> firsts;
  const std::vector<Random::Key> keys = {{1, 2, 3, 4},  {5, 2, 3, 4}, {1, 5, 3, 4},
                                         {1, 2, 5, 4},  {1, 2, 3, 5}, {1, 2, 3 + far, 4},
                                         {1, 2, -3, 4}, {4, 2, 3, 1}, {1ull << 40, 2, 3, 4}};
  for (const Random::Key& key : keys) firsts.insert(draws(key, 1).front());
  EXPECT_EQ(firsts.size(), keys.size());
}

TEST(Random, UniformFillsTheOpenInterval) {
  constexpr int kCount = 100'000;
  double sum = 0.0;
  double square_sum = 0.0;
  for (const double u : draws({.seed = 9, .slot = 0, .stamp = 0, .sensor = 0}, kCount)) {
    ASSERT_GT(u, 0.0);
    ASSERT_LT(u, 1.0);
    sum += u;
    square_sum += u * u;
  }
  EXPECT_NEAR(sum / kCount, 0.5, 0.005);
  EXPECT_NEAR(square_sum / kCount, 1.0 / 3.0, 0.005);
}

TEST(Random, NormalHasTheMomentsOfANormal) {
  constexpr int kCount = 100'000;
  Random random({.seed = 11, .slot = 5, .stamp = -7, .sensor = 1});
  double moments[5] = {};
  for (int i = 0; i < kCount; ++i) {
    const double x = random.normal();
    for (int k = 1; k <= 4; ++k) moments[k] += std::pow(x, k) / kCount;
  }
  EXPECT_NEAR(moments[1], 0.0, 0.015);
  EXPECT_NEAR(moments[2], 1.0, 0.02);
  EXPECT_NEAR(moments[3], 0.0, 0.05);
  EXPECT_NEAR(moments[4], 3.0, 0.12);
}

TEST(Random, NeighbouringParticlesAreUncorrelated) {
  constexpr int kCount = 20'000;
  double product = 0.0;
  for (int i = 0; i < kCount; ++i) {
    const auto stamp = static_cast<std::int64_t>(i) * 1'000'000;
    Random a({.seed = 1, .slot = 0, .stamp = stamp, .sensor = 0});
    Random b({.seed = 1, .slot = 1, .stamp = stamp, .sensor = 0});
    product += a.normal() * b.normal() / kCount;
  }
  EXPECT_NEAR(product, 0.0, 0.03);
}

}  // namespace
}  // namespace waymark
