// SPDX-License-Identifier: Apache-2.0
#include "fix_continuity.hpp"

#include <gtest/gtest.h>

namespace waymark::dgps {
namespace {

/// A receiver on a robot that drives at `speed`, a fix every `dt`.
struct Bench {
  FixContinuity& at(double east, double north) {
    FixStep step;
    step.stamp = Time{from_seconds(t)};
    step.z = {east, north};
    step.white_sigma = white;
    step.slow_sigma = 2.0 * white;
    step.slow_tau_s = 60.0;
    step.speed = speed;
    step.speed_sigma = 0.02;
    t += dt;
    continuity.take(step);
    return continuity;
  }
  /// With a fix at the origin that the host accepted.
  static Bench of(double white, double speed, double dt = 1.0) {
    Bench bench{.white = white, .speed = speed, .dt = dt};
    bench.at(0.0, 0.0).accept();
    return bench;
  }

  FixContinuity continuity = {};
  double white = 0.01;
  double speed = 1.0;
  double dt = 1.0;
  double t = 100.0;
};

TEST(FixContinuity, AFixAsFarAwayAsTheRobotDroveFollowsInWhateverDirection) {
  for (const Eigen::Vector2d& z : {Eigen::Vector2d(1.0, 0.0), Eigen::Vector2d(0.0, -1.05), Eigen::Vector2d(-0.9, 0.3)})
    EXPECT_TRUE(Bench::of(0.01, 1.0).at(z.x(), z.y()).is_unbroken()) << z.transpose();
}

TEST(FixContinuity, AFixFartherAwayJumped) {
  EXPECT_FALSE(Bench::of(0.01, 1.0).at(1.4, 0.0).is_unbroken());
  EXPECT_FALSE(Bench::of(0.5, 1.0).at(4.0, 0.0).is_unbroken());
  EXPECT_TRUE(Bench::of(0.5, 1.0).at(3.0, 0.0).is_unbroken());
}

TEST(FixContinuity, AFixThatStaysBehindWhileTheRobotDrivesDoesNotFollow) {
  EXPECT_FALSE(Bench::of(0.01, 1.0).at(0.2, 0.0).is_unbroken());
}

TEST(FixContinuity, FixesAfterAJumpDoNotFollowUntilOneIsAccepted) {
  Bench bench = Bench::of(0.01, 1.0);
  bench.at(5.0, 0.0);
  for (int i = 1; i < 5; ++i) EXPECT_FALSE(bench.at(5.0 + i, 0.0).is_unbroken()) << i;
  bench.continuity.accept();
  EXPECT_TRUE(bench.at(10.0, 0.0).is_unbroken());
}

TEST(FixContinuity, OneFixOfAGoodReceiverIsCertainSomeOfAPoorOneAreNeeded) {
  EXPECT_TRUE(Bench::of(0.01, 1.5).at(0.0, 1.5).is_certain());
  Bench poor = Bench::of(0.5, 2.0);
  EXPECT_FALSE(poor.at(0.0, 2.0).is_certain());
  EXPECT_TRUE(poor.at(0.0, 4.0).is_certain());
}

TEST(FixContinuity, AfterALongGapMoreOfThemAreNeeded) {
  Bench bench = Bench::of(0.01, 1.0, 60.0);
  EXPECT_FALSE(bench.at(0.0, 50.0).is_certain());
  bench.dt = 1.0;
  bench.t -= 59.0;
  EXPECT_FALSE(bench.at(0.0, 51.0).is_certain());
  EXPECT_TRUE(bench.at(0.0, 52.0).is_certain());
}

TEST(FixContinuity, AnAcceptedFixBeginsANewRun) {
  Bench poor = Bench::of(0.5, 2.0);
  poor.at(0.0, 2.0);
  poor.continuity.accept();
  EXPECT_FALSE(poor.at(0.0, 4.0).is_certain());
}

}  // namespace
}  // namespace waymark::dgps
