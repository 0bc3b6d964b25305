// SPDX-License-Identifier: Apache-2.0
#include "fix_monitor.hpp"

#include <gtest/gtest.h>

#include <sstream>

namespace waymark::dgps {
namespace {

using Verdict = FixMonitor::Verdict;

/// A robot that drives east at `speed` and a receiver beside it, once a second.
struct Bench {
  explicit Bench(const std::string& yaml = "{}") : monitor(Config::parse(yaml)) {}

  /// The fix lies `error` off what the filter expects.
  Verdict see(const Eigen::Vector2d& error) { return see_at(expected + error); }
  Verdict see_at(const Eigen::Vector2d& z) {
    ObservedFix fix;
    fix.stamp = Time{from_seconds(t)};
    fix.z = z;
    fix.innovation = z - expected;
    fix.S = 2.0 * sigma * sigma * Eigen::Matrix2d::Identity();
    fix.sigma = sigma;
    fix.speed = speed;
    fix.speed_sigma = 0.05;
    fix.standing = speed == 0.0;
    t += 1.0;
    expected.x() += speed;
    return monitor.judge(fix);
  }

  FixMonitor monitor;
  double t = 100.0;
  double speed = 2.0;
  double sigma = 0.5;
  Eigen::Vector2d expected = Eigen::Vector2d::Zero();
};

TEST(FixMonitor, FixesNearTheExpectationAreGood) {
  Bench bench;
  for (int i = 0; i < 50; ++i) EXPECT_EQ(bench.see({0.3 * (i % 3), -0.2 * (i % 5)}), Verdict::good) << i;
}

TEST(FixMonitor, AJumpThatTheCovarianceExplainsIsNone) {
  Bench bench;
  bench.see({0.0, 0.0});
  EXPECT_EQ(bench.see({4.2, 0.0}), Verdict::good);  // 5.9 of √(2·0.5²)
  EXPECT_EQ(bench.see({0.0, 4.3}), Verdict::jump);  // 6.1
}

TEST(FixMonitor, TheFirstFixHasNothingToJumpFrom) {
  Bench bench;
  EXPECT_EQ(bench.see({500.0, 0.0}), Verdict::good);
}

TEST(FixMonitor, JumpsThatAgreeAreBelievedWhenThePatienceIsOver) {
  Bench bench("{ jump_patience: 4 }");
  bench.see({0.0, 0.0});
  for (int i = 0; i < 4; ++i) EXPECT_EQ(bench.see({80.0, 30.0}), Verdict::jump) << i;
  for (int i = 0; i < 30; ++i) EXPECT_EQ(bench.see({80.0, 30.0}), Verdict::good) << i;
}

TEST(FixMonitor, AWrongHeadingOfTheFilterLocksNothingOut) {
  Bench bench("{ jump_patience: 4 }");
  for (int i = 0; i < 3; ++i) bench.see({0.0, 0.0});
  int rejected = 0;
  const Eigen::Vector2d from = bench.expected;
  for (int i = 0; i < 40; ++i) rejected += bench.see_at(from + Eigen::Vector2d(0.0, 2.0 * i)) != Verdict::good;
  EXPECT_EQ(rejected, 4);
}

TEST(FixMonitor, JumpsThatDisagreeAreNotBelievedForLong) {
  Bench bench("{ jump_patience: 5 }");
  bench.see({0.0, 0.0});
  for (int i = 0; i < 15; ++i) EXPECT_EQ(bench.see({(i % 2 ? 300.0 : -300.0), 90.0 * i}), Verdict::jump) << i;
  EXPECT_EQ(bench.see({0.5, 0.0}), Verdict::good);
}

TEST(FixMonitor, NorAreTheyDoubtedForEver) {
  Bench bench("{ jump_patience: 5 }");
  bench.see({0.0, 0.0});
  int i = 0;
  while (bench.see({(i % 2 ? 300.0 : -300.0), 90.0 * i}) == Verdict::jump && i < 100) ++i;
  EXPECT_EQ(i, 20);
}

TEST(FixMonitor, OneGoodFixEndsTheCount) {
  Bench bench("{ jump_patience: 3 }");
  bench.see({0.0, 0.0});
  for (int turn = 0; turn < 5; ++turn) {
    for (int i = 0; i < 3; ++i) EXPECT_EQ(bench.see({60.0, 0.0}), Verdict::jump);
    EXPECT_EQ(bench.see({0.0, 0.0}), Verdict::good);
  }
}

TEST(FixMonitor, APositionThatStaysWhileTheRobotMovesIsFrozen) {
  Bench bench("{ frozen_distance_m: 3 }");
  bench.sigma = 50.0;  // no jump
  const Eigen::Vector2d stuck(1.0, 2.0);
  EXPECT_EQ(bench.see_at(stuck), Verdict::good);
  EXPECT_EQ(bench.see_at(stuck), Verdict::good);  // 1.9 m
  for (int i = 0; i < 100; ++i) EXPECT_EQ(bench.see_at(stuck), Verdict::frozen) << i;
  EXPECT_EQ(bench.see_at({1.0, 2.2}), Verdict::good);
}

TEST(FixMonitor, AtStandstillTheSamePositionIsNoFault) {
  Bench bench;
  bench.speed = 0.0;
  for (int i = 0; i < 100; ++i) EXPECT_EQ(bench.see_at({1.0, 2.0}), Verdict::good) << i;
}

TEST(FixMonitor, ANoisySpeedNearZeroIsNoMotion) {
  Bench bench("{ jump_sigmas: 0 }");
  bench.speed = 0.09;  // below 2σ
  for (int i = 0; i < 100; ++i) EXPECT_EQ(bench.see_at({1.0, 2.0}), Verdict::good) << i;
}

TEST(FixMonitor, APositionThatWandersWhileTheRobotStandsDrifts) {
  Bench bench("{ jump_sigmas: 0, drift_patience_s: 20 }");
  bench.speed = 0.0;
  int drifting = 0;
  int first = -1;
  for (int i = 0; i < 40; ++i) {
    if (bench.see({0.1 * i, 0.0}) != Verdict::drifting) continue;
    ++drifting;
    if (first < 0) first = i;
  }
  EXPECT_EQ(first, 28);  // 2.5 m from the mean of the first five, 0.2
  EXPECT_EQ(drifting, 12);
}

TEST(FixMonitor, ADriftIsBelievedInTheEnd) {
  Bench bench("{ jump_sigmas: 0, drift_patience_s: 20 }");
  bench.speed = 0.0;
  for (int i = 0; i < 5; ++i) bench.see({0.0, 0.0});
  for (int i = 0; i < 20; ++i) EXPECT_EQ(bench.see({4.0, 0.01 * i}), Verdict::drifting) << i;
  for (int i = 0; i < 20; ++i) EXPECT_EQ(bench.see({4.0, 0.01 * i}), Verdict::good) << i;
}

TEST(FixMonitor, ZeroTurnsACheckOff) {
  Bench bench("{ jump_sigmas: 0, frozen_distance_m: 0, drift_sigmas: 0 }");
  for (int i = 0; i < 10; ++i) EXPECT_EQ(bench.see_at({900.0, 0.0}), Verdict::good);
  bench.speed = 0.0;
  for (int i = 0; i < 20; ++i) EXPECT_EQ(bench.see_at({900.0 * i, 0.0}), Verdict::good);
}

TEST(FixMonitor, EveryDoubtHasAReason) {
  EXPECT_TRUE(FixMonitor::reason(Verdict::good).empty());
  for (const Verdict verdict : {Verdict::jump, Verdict::frozen, Verdict::drifting}) {
    EXPECT_FALSE(FixMonitor::reason(verdict).empty());
  }
}

TEST(FixMonitor, ContinuesWhereItWasSaved) {
  Bench bench("{ jump_patience: 4 }");
  bench.see({0.0, 0.0});
  for (int i = 0; i < 3; ++i) bench.see({80.0, 30.0});
  std::stringstream stream;
  OutArchive out(stream);
  out(bench.monitor);
  Bench other("{ jump_patience: 4 }");
  InArchive in(stream);
  in(other.monitor);
  other.t = bench.t;
  other.expected = bench.expected;
  EXPECT_EQ(other.see({80.0, 30.0}), Verdict::jump);
  EXPECT_EQ(other.see({80.0, 30.0}), Verdict::good);
}

}  // namespace
}  // namespace waymark::dgps
