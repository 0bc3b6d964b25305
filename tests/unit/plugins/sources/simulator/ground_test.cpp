// SPDX-License-Identifier: Apache-2.0
#include "ground.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "world.hpp"

namespace waymark::simulator {
namespace {

constexpr double kNothing = World::kNothing;

/// From (2, 0) on the ground to (12, 0), 2 m high; 3 m wide.
const Deck kRamp{{2.0, 0.0}, {1.0, 0.0}, 10.0, 1.5, 0.0, 2.0, 0.5, 0.0};
/// From x = 12 to 20, y = -4 to 4.
const Deck kFloor{{12.0, 0.0}, {1.0, 0.0}, 8.0, 4.0, 2.0, 2.0, 4.0, 1.8};
const std::vector<Wave> kWaves{{{1.1, 0.7}, 0.3, 0.05}, {{-0.4, 1.5}, 1.9, 0.04}};

TEST(Ground, ARampIsStraightBetweenItsRoundings) {
  // 2 m over 10 m less half a rounding at both ends.
  const double slope = 2.0 / 9.5;
  EXPECT_NEAR(kRamp.steepest(), slope, 1e-12);
  EXPECT_EQ(kRamp.height(-1.0), 0.0);
  EXPECT_EQ(kRamp.height(11.0), 2.0);
  EXPECT_NEAR(kRamp.height(5.0), 1.0, 1e-12);
  EXPECT_NEAR(kRamp.height(0.5), 0.25 * slope, 1e-12);
  EXPECT_NEAR(kRamp.height(0.5 + 1e-9), 0.25 * slope, 1e-8);
  EXPECT_NEAR(kRamp.height(9.5), 2.0 - 0.25 * slope, 1e-12);
}

TEST(Ground, ItsDerivativesAreThoseOfItsHeight) {
  const Deck oblique{{2.0, 1.0}, {0.6, 0.8}, 10.0, 2.0, 0.5, 2.0, 3.0, 0.5};
  const Ground ground({oblique}, kWaves);
  std::mt19937 generator(5);
  std::uniform_real_distribution<double> coordinate(-2.0, 14.0);
  constexpr double h = 1e-5;
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector2d p(coordinate(generator), coordinate(generator));
    const double s = (p - oblique.from).dot(oblique.along);
    const auto bends_at = [&](double at) { return std::abs(s - at) < 2.0 * h; };
    if (bends_at(0.0) || bends_at(3.0) || bends_at(7.0) || bends_at(10.0)) continue;
    const auto z = [&](double x, double y) { return ground.at(0, p + Eigen::Vector2d(x, y)); };
    const Slope slope = z(0.0, 0.0);
    ASSERT_NEAR(slope.z_x, (z(h, 0).z - z(-h, 0).z) / (2 * h), 1e-8);
    ASSERT_NEAR(slope.z_y, (z(0, h).z - z(0, -h).z) / (2 * h), 1e-8);
    ASSERT_NEAR(slope.z_xx, (z(h, 0).z_x - z(-h, 0).z_x) / (2 * h), 1e-8);
    ASSERT_NEAR(slope.z_xy, (z(0, h).z_x - z(0, -h).z_x) / (2 * h), 1e-8);
    ASSERT_NEAR(slope.z_yy, (z(0, h).z_y - z(0, -h).z_y) / (2 * h), 1e-8);
  }
}

TEST(Ground, AWheelStandsOnTheHighestSurfaceThatIsNotAboveIt) {
  const Ground ground({kRamp, kFloor}, {});
  EXPECT_EQ(ground.below({1.0, 0.0}, 0.0), Ground::kLowest);
  EXPECT_EQ(ground.below({7.0, 0.0}, 1.0), 0);
  EXPECT_EQ(ground.below({14.0, 0.0}, 2.0), 1);
  EXPECT_EQ(ground.below({14.0, 0.0}, 0.0), Ground::kLowest);  // under the floor
  EXPECT_EQ(ground.below({14.0, 0.0}, 1.9), std::nullopt);     // into its edge
  EXPECT_EQ(ground.below({7.0, 1.4}, 0.0), std::nullopt);      // into the side of the ramp
  EXPECT_EQ(ground.below({7.0, 1.6}, 0.0), Ground::kLowest);   // past it
  EXPECT_EQ(ground.below({2.1, 0.0}, 0.0), 0);                 // up its foot
}

TEST(Ground, RaysMeetRampAndFloorAtTheirDistances) {
  const Ground ground({kRamp, kFloor}, {});
  const auto cast = [&](const Eigen::Vector3d& from, const Eigen::Vector3d& along) {
    return ground.cast(from, along.normalized(), true, kNothing);
  };
  // The straight part is z = slope (x - 2 - 0.25): a level ray at 1 m meets it where the ramp is 1 m high.
  EXPECT_NEAR(cast({0, 0, 1}, {1, 0, 0}), 7.0, 1e-6);
  EXPECT_NEAR(cast({0, 0, 1}, {1, 0, -0.1}), std::hypot(1.0, 0.1) * (1.0 + 2.25 * 2.0 / 9.5) / (0.1 + 2.0 / 9.5), 1e-6);
  EXPECT_NEAR(cast({7, 0, 3}, {0, 0, -1}), 2.0, 1e-6);
  EXPECT_NEAR(cast({7, 5, 0.5}, {0, -1, 0}), 3.5, 1e-9);   // its side
  EXPECT_EQ(cast({7, 5, 1.5}, {0, -1, 0}), kNothing);      // over it
  EXPECT_NEAR(cast({16, 0, 0.5}, {-1, 0, 0}), 4.0, 1e-9);  // its end, from below the floor
  EXPECT_NEAR(cast({16, 0, 0.5}, {0, 0, 1}), 1.3, 1e-9);   // the floor from below
  EXPECT_NEAR(cast({16, 0, 2.8}, {0, 0, -1}), 0.8, 1e-6);  // and from above
  EXPECT_NEAR(cast({16, 6, 1.9}, {0, -1, 0}), 2.0, 1e-9);  // its edge
  EXPECT_NEAR(cast({16, 6, 2.8}, {0, 0, -1}), 2.8, 1e-9);  // beside it
  EXPECT_NEAR(cast({0, 0, 0.8}, {-1, 0, -1}), 0.8 * std::sqrt(2.0), 1e-9);
  EXPECT_EQ(ground.cast({16, 6, 2.8}, {0, 0, -1}, false, kNothing), kNothing);
  EXPECT_EQ(ground.cast({7, 0, 3}, {0, 0, -1}, true, 1.5), 1.5);
}

/// Is the point in the ground, in the ramp or in the floor?
bool is_inside(const Ground& ground, const Eigen::Vector3d& p) {
  if (p.z() < ground.at(Ground::kLowest, p.head<2>()).z) return true;
  for (std::size_t i = 0; i < ground.decks().size(); ++i) {
    const Deck& deck = ground.decks()[i];
    if (deck.covers(p.head<2>()) && p.z() >= deck.base_m && p.z() <= ground.at(static_cast<int>(i), p.head<2>()).z)
      return true;
  }
  return false;
}

TEST(Ground, NoRayPassesThroughUnevenGround) {
  const Ground ground({kRamp, kFloor}, kWaves);
  std::mt19937 generator(7);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  int hits = 0;
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector3d origin(22.0 * unit(generator), 10.0 * unit(generator) - 5.0, 0.2 + 3.5 * unit(generator));
    if (is_inside(ground, origin)) continue;
    const double azimuth = 7.0 * unit(generator);
    const Eigen::Vector3d along =
        Eigen::Vector3d(std::cos(azimuth), std::sin(azimuth), 2.0 * unit(generator) - 1.2).normalized();
    const double met = ground.cast(origin, along, true, 15.0);
    constexpr double kStep = 0.005;
    double stepped = kStep;
    while (stepped < 15.0 && !is_inside(ground, origin + stepped * along)) stepped += kStep;
    // A ray that grazes a bump or an edge may meet it between two steps.
    if (met < stepped - kStep) {
      ASSERT_TRUE(is_inside(ground, origin + (met + 1e-6) * along) ||
                  is_inside(ground, origin + met * along - Eigen::Vector3d(0, 0, 2e-6)))
          << i;
    } else {
      ASSERT_NEAR(met, std::min(stepped, 15.0), kStep + 1e-6) << i;
    }
    if (met < 15.0) ++hits;
  }
  EXPECT_GT(hits, 150);
}

}  // namespace
}  // namespace waymark::simulator
