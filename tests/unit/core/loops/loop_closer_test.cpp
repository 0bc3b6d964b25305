// SPDX-License-Identifier: Apache-2.0
#include "loops/loop_closer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "waymark/math/gaussian.hpp"
#include "waymark/math/random.hpp"

namespace waymark::loops {
namespace {

/// Walls along a square way of 20 m with niches at irregular places, as points.
std::vector<Eigen::Vector2d> surroundings(std::uint64_t seed, double half_width) {
  std::vector<Eigen::Vector2d> points;
  Random random({seed, 0, 0, 0});
  for (const double inset : {-half_width, half_width}) {
    const double low = inset;
    const double high = 20.0 - inset;
    double depth = 0.0;
    for (double s = low; s < high; s += 0.08) {
      if (random.uniform() < 0.03) depth = 2.0 * random.uniform();
      const double out = inset < 0.0 ? -depth : depth;
      points.emplace_back(s, low + out);
      points.emplace_back(s, high - out);
      points.emplace_back(low + out, s);
      points.emplace_back(high - out, s);
    }
  }
  return points;
}

/// Drives `rounds` times around the square. Its dead reckoning drifts, and no map corrects it.
class Drive {
 public:
  explicit Drive(LoopSettings settings = {}) : closer_(settings, {}) {}

  /// After so much way the path jumps, and its covariance does not show it.
  void slip(double after, const Eigen::Vector3d& jump) {
    slip_after_ = after;
    jump_ = jump;
  }

  /// After so much way all looks otherwise.
  void rebuild(double after) { rebuild_after_ = after; }

  void go(double way, std::uint64_t seed) {
    Random random({seed, 1, 0, 0});
    const Eigen::Matrix3d P = Eigen::Vector3d(0.02, 0.01, 0.008).cwiseAbs2().asDiagonal();
    const std::vector<Eigen::Vector2d> first = surroundings(5, 3.0);
    const std::vector<Eigen::Vector2d> second = surroundings(6, 2.0);
    double driven = 0.0;
    double side = 0.0;
    for (; driven < way; driven += 0.5) {
      const bool turns = side >= 20.0;
      const Eigen::Vector3d step =
          turns ? Eigen::Vector3d(0.0, 0.0, std::numbers::pi / 2.0) : Eigen::Vector3d(0.5, 0, 0);
      side = turns ? 0.0 : side + 0.5;
      truth_ = compose(truth_, step);
      Eigen::Vector3d measured = step + gaussian::sample(P, random);
      if (driven == slip_after_) measured = compose(measured, jump_);
      reckoned_ = compose(reckoned_, measured);
      uncorrected_ = compose(uncorrected_, measured);
      Keyframe keyframe;
      keyframe.stamp = Time{from_seconds(driven)};
      keyframe.xyyaw = reckoned_;
      keyframe.P = P;
      see(driven < rebuild_after_ ? first : second, keyframe.points_base);
      closer_.add(std::move(keyframe));
      path_.push_back({Time{from_seconds(driven)}, pose(reckoned_)});
      if (const auto correction = closer_.search([this]() -> const std::vector<StampedPose>& { return path_; })) {
        corrections_.push_back(*correction);
        for (std::size_t i = 0; i < path_.size(); ++i) path_[i].T_map_base = pose(closer_.keyframes()[i].xyyaw);
        reckoned_ = closer_.keyframes().back().xyyaw;
      }
      missed_a_place_ = missed_a_place_ || closer_.fails_to_recognise();
    }
  }

  double error() const { return (reckoned_ - truth_).head<2>().norm(); }
  double error_without() const { return (uncorrected_ - truth_).head<2>().norm(); }
  const std::vector<Correction>& corrections() const { return corrections_; }
  const LoopCloser& closer() const { return closer_; }
  bool missed_a_place() const { return missed_a_place_; }

 private:
  /// The points up to 8 m from the robot. Plain numbers: tests are compiled without optimisation, and there are
  /// millions.
  void see(const std::vector<Eigen::Vector2d>& points, std::vector<Eigen::Vector2f>& seen) const {
    const double x = truth_.x();
    const double y = truth_.y();
    const double c = std::cos(truth_.z());
    const double s = std::sin(truth_.z());
    for (const Eigen::Vector2d& p : points) {
      const double dx = p.x() - x;
      const double dy = p.y() - y;
      if (dx * dx + dy * dy >= 64.0) continue;
      seen.emplace_back(static_cast<float>(c * dx + s * dy), static_cast<float>(c * dy - s * dx));
    }
  }

  static Pose pose(const Eigen::Vector3d& xyyaw) {
    Pose pose;
    pose.p.head<2>() = xyyaw.head<2>();
    pose.q = so3::exp({0.0, 0.0, xyyaw.z()});
    return pose;
  }

  LoopCloser closer_;
  Eigen::Vector3d truth_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d reckoned_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d uncorrected_ = Eigen::Vector3d::Zero();
  std::vector<StampedPose> path_;
  std::vector<Correction> corrections_;
  double slip_after_ = -1.0;
  double rebuild_after_ = 1e9;
  Eigen::Vector3d jump_ = Eigen::Vector3d::Zero();
  bool missed_a_place_ = false;
};

TEST(LoopCloser, CorrectsAPathThatMeetsItsBeginning) {
  int closed = 0;
  double with = 0.0;
  double without = 0.0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Drive drive;
    drive.go(130.0, seed);
    closed += drive.corrections().empty() ? 0 : 1;
    with += drive.error();
    without += drive.error_without();
  }
  EXPECT_LT(with, 0.5 * without);
  EXPECT_EQ(closed, 5);
}

TEST(LoopCloser, BridgesWhatLiesBetweenTwoVisitsOfAPlace) {
  Drive once;
  once.go(60.0, 1);
  EXPECT_FALSE(once.closer().is_bridged(Time{from_seconds(40.0)}));
  Drive twice;
  twice.go(130.0, 1);
  EXPECT_TRUE(twice.closer().is_bridged(Time{from_seconds(40.0)}));
  EXPECT_FALSE(twice.closer().is_bridged(Time{from_seconds(129.0)}));  // nothing after it was met before
}

TEST(LoopCloser, LeavesAPathAloneThatMeetsNothing) {
  Drive drive;
  drive.go(70.0, 1);
  EXPECT_TRUE(drive.corrections().empty());
  EXPECT_TRUE(drive.closer().loops().empty());
}

TEST(LoopCloser, MendsAPathThatTearsInAKnownPlace) {
  const Eigen::Vector3d jump(0.9, -0.7, 0.12);
  int mended = 0;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Drive torn;
    torn.slip(140.0, jump);
    torn.go(240.0, seed);
    Drive right;
    right.go(240.0, seed);
    EXPECT_FALSE(right.missed_a_place()) << seed;
    mended += torn.error() < right.error() + 0.5 * jump.head<2>().norm() ? 1 : 0;
  }
  EXPECT_EQ(mended, 3);
}

TEST(LoopCloser, ReportsPlacesThatDoNotLookAsBefore) {
  int reported = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Drive drive;
    drive.rebuild(140.0);
    drive.go(180.0, seed);
    reported += drive.missed_a_place() ? 1 : 0;
  }
  EXPECT_GE(reported, 3);  // the path of the others is too uncertain by then
}

TEST(LoopCloser, CarriesAlongWhatCameAfterACorrection) {
  LoopCloser closer({}, {});
  std::vector<StampedPose> path;
  for (int i = 0; i < 5; ++i) {
    const Pose pose = Pose::planar(i, 0.0, 0.0);
    Keyframe keyframe;
    keyframe.stamp = Time{from_seconds(i)};
    // Up to the third one they were moved by a correction: one metre to the left, turned by 90°.
    keyframe.xyyaw = i < 3 ? Eigen::Vector3d(0.0, 1.0 + i, std::numbers::pi / 2.0) : planar(pose);
    closer.add(keyframe);
    path.push_back({keyframe.stamp, pose});
  }
  const std::vector<Eigen::Vector3d> before = closer.carry(2, path);
  ASSERT_EQ(before.size(), 3U);
  for (int i = 2; i < 5; ++i) {
    const auto at = static_cast<std::size_t>(i);
    EXPECT_LT((before[at - 2] - Eigen::Vector3d(i, 0.0, 0.0)).norm(), 1e-12);
    EXPECT_LT((closer.keyframes()[at].xyyaw - Eigen::Vector3d(0.0, 1.0 + i, std::numbers::pi / 2.0)).norm(), 1e-12);
  }
}

// Whatever the spacing of keyframes is: with one spacing, all odd ones may be nodes.
TEST(LoopCloser, IsFullOfPlacesOnly) {
  for (const double spacing : {0.2, 0.25, 0.5}) {
    LoopCloser closer(LoopSettings{}, {});
    double x = 0.0;
    for (; !closer.is_full() && x < 40e3; x += spacing) {
      Keyframe keyframe;
      keyframe.stamp = Time{from_seconds(x)};
      keyframe.xyyaw = {x, 0.0, 0.0};
      keyframe.P = 1e-6 * Eigen::Matrix3d::Identity();
      closer.add(std::move(keyframe));
      closer.bound();
    }
    EXPECT_GT(x, 19e3) << spacing;
    EXPECT_LT(x, 22e3) << spacing;
    double variance = 0.0;
    for (const Keyframe& keyframe : closer.keyframes()) variance += keyframe.P(0, 0);
    EXPECT_NEAR(variance, 1e-6 * x / spacing, 1e-6) << "no error of the path is lost";
    EXPECT_NEAR(closer.keyframes().back().xyyaw.x(), x - spacing, 1e-6);
  }
}

TEST(LoopCloser, KeepsFewKeyframesOfARobotThatStands) {
  LoopCloser closer(LoopSettings{}, {});
  Random random({1, 2, 0, 0});
  const Eigen::Matrix3d jitter = Eigen::Vector3d(0.002, 0.002, 0.001).cwiseAbs2().asDiagonal();
  for (int i = 0; i < 1000; ++i) {
    Keyframe keyframe;
    keyframe.stamp = Time{from_seconds(i)};
    keyframe.xyyaw = gaussian::sample(jitter, random);
    keyframe.xyyaw.x() += std::min(i, 9);
    keyframe.P = 1e-6 * Eigen::Matrix3d::Identity();
    closer.add(std::move(keyframe));
  }
  ASSERT_EQ(closer.keyframes().size(), 9U + 20U);
  EXPECT_NEAR(closer.keyframes().back().P(0, 0), 972e-6, 1e-9) << "what it may have moved meanwhile counts";
}

TEST(LoopCloser, ForgetsWhatARewindTakesBack) {
  Drive drive;
  drive.go(130.0, 1);
  LoopCloser closer = drive.closer();
  closer.rewind(Time{from_seconds(40.0)});
  EXPECT_EQ(closer.keyframes().back().stamp, Time{from_seconds(40.0)});
  closer.rewind(Time{from_seconds(-1.0)});
  EXPECT_TRUE(closer.keyframes().empty());
}

}  // namespace
}  // namespace waymark::loops
