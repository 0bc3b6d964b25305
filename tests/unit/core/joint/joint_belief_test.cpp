// SPDX-License-Identifier: Apache-2.0
#include "joint/joint_belief.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "waymark/math/so3.hpp"

namespace waymark::joint {
namespace {

const StateLayout& planar() {
  static const StateLayout layout(StateLayout::Motion::planar, {});
  return layout;
}

/// A robot at 1 m/s whose heading drifts, with a precise scanner of short reach: it sees its own surroundings.
class Drive {
 public:
  explicit Drive(const JointSettings& settings = {}, std::optional<double> return_way = {})
      : process_(planar(), noise()), joint_(process_, settings, return_way) {
    Belief start;
    start.mean.v_base.x() = 1.0;
    start.P = ErrorMatrix::Zero(6, 6);
    start.P(3, 3) = start.P(5, 5) = 1e-4;
    joint_.start(start, Eigen::Matrix3d::Zero());
  }

  /// Drives for `seconds` with this turn rate [rad/s], a match every half second.
  void drive(double seconds, double rate) {
    for (double t = 0.0; t < seconds; t += 0.5) {
      // Wheels and gyro.
      joint_.replace_twist([rate](Belief& belief) {
        belief.mean.v_base = {1.0, 0.0, 0.0};
        belief.mean.w_base = {0.0, 0.0, rate};
        for (const int i : {3, 4, 5}) {
          belief.P.row(i).setZero();
          belief.P.col(i).setZero();
          belief.P(i, i) = 1e-4;
        }
      });
      stamp_ += from_seconds(0.5);
      joint_.predict(stamp_, false);
      match();
    }
  }
  void match() {
    Correspondences seen;
    seen.points_base = ring();
    // The particle is where the Gaussian has it: the match confirms that.
    const Pose pose = joint_.belief().mean.T_map_base;
    const Eigen::Vector3d xyyaw(pose.p.x(), pose.p.y(), pose.yaw());
    const PoseMatch match{xyyaw, Eigen::Vector3d(1e4, 1e4, 1e5).asDiagonal(), Eigen::Vector3d::Zero()};
    if (const auto added = joint_.map({.match = match, .T_map_base = pose}, seen, anchors_))
      anchors_.push_back({*added, xyyaw});
    all_.resize(std::max(all_.size(), anchors_.size()));
    if (!anchors_.empty()) all_[anchors_.size() - 1] = anchors_.back().anchor;
  }
  /// A camera sees so many landmarks for the first time.
  void see_landmarks(std::uint64_t count) {
    Correspondences seen;
    for (std::uint64_t i = 1; i <= count; ++i)
      seen.landmarks.push_back({i, true, {static_cast<double>(i), 2.0}, 0.04 * Eigen::Matrix2d::Identity()});
    joint_.map({.match = {Eigen::Vector3d::Zero(), Eigen::Matrix3d::Zero(), Eigen::Vector3d::Zero()}}, seen, {});
  }
  /// The path was corrected: all anchors but the first two are gone, and only the first is known.
  void begin_anew(double anchor_sigma) {
    anchors_.resize(2);
    Eigen::MatrixXd P = Eigen::MatrixXd::Zero(9, 9);
    P.bottomRightCorner(6, 6) = anchor_sigma * anchor_sigma * Eigen::MatrixXd::Identity(6, 6);
    Belief particle = joint_.belief();
    particle.P.topLeftCorner(3, 3).setZero();
    joint_.begin_anew(particle, {}, anchors_, P);
    keyframes_.resize(1);
    keyframes_[0].anchor = anchors_[0].anchor;
    const Pose pose = joint_.belief().mean.T_map_base;
    keyframes_[0].xyyaw = {pose.p.x(), pose.p.y(), pose.yaw()};
    for (const Eigen::Vector2d& point : ring()) keyframes_[0].points_base.push_back(point.cast<float>());
  }
  /// What is around the robot was mapped from the first anchor.
  void claim_for_first() { joint_.draw_again(keyframes_, anchors_); }
  /// The pose is given, as certain as this in all directions [m, rad].
  void restart(const Eigen::Vector3d& xyyaw, double sigma) {
    Belief belief = joint_.belief();
    belief.mean.T_map_base.p = {xyyaw.x(), xyyaw.y(), 0.0};
    belief.mean.T_map_base.q = so3::exp({0.0, 0.0, xyyaw.z()});
    belief.P = sigma * sigma * ErrorMatrix::Identity(6, 6);
    joint_.restart(belief);
  }
  std::size_t kept_anchors() const {
    return static_cast<std::size_t>(
        std::ranges::count_if(anchors_, [this](const AnchorPose& anchor) { return joint_.has_anchor(anchor.anchor); }));
  }
  /// A scan that shows what is around the robot, so far ahead of where it is.
  bool returns_uncertainly(double ahead) const {
    Pose pose = joint_.belief().mean.T_map_base;
    pose.p += pose.q * Eigen::Vector3d(ahead, 0.0, 0.0);
    return joint_.returns_uncertainly(ring(), pose);
  }
  bool awaits_graph() const { return joint_.awaits_graph(); }
  bool has_anchor(std::size_t i) const { return joint_.has_anchor(all_[i]); }
  Eigen::Matrix3d P() const { return pose_covariance(joint_.belief(), planar()); }
  std::size_t anchors() const { return anchors_.size(); }

 private:
  static std::vector<Eigen::Vector2d> ring() {
    std::vector<Eigen::Vector2d> points;
    for (int i = 0; i < 24; ++i) {
      const double angle = i * std::numbers::pi / 12.0;
      points.emplace_back(3.0 * std::cos(angle), 3.0 * std::sin(angle));
    }
    return points;
  }
  static ProcessNoise noise() {
    ProcessNoise noise;
    noise.velocity_per_sqrt_s = {0.02, 0.02, 0.0};
    noise.rate_per_sqrt_s = {0.0, 0.0, 0.02};
    return noise;
  }
  estimation::ProcessModel process_;
  JointBelief joint_;
  std::vector<AnchorPose> anchors_;
  std::vector<JointGaussian::NodeId> all_;  // of all anchors that were ever added
  std::vector<loops::Keyframe> keyframes_;
  Time stamp_{};
};

double sigma(const Drive& drive) { return std::sqrt(drive.P()(0, 0) + drive.P()(1, 1)); }

TEST(JointBelief, GrowsInNewGroundAndShrinksWhereTheLoopIsClosed) {
  constexpr double kQuarter = 0.5 * std::numbers::pi;
  Drive drive;
  drive.match();
  std::vector<double> sides;
  for (int side = 0; side < 4; ++side) {
    drive.drive(20.0, 0.0);
    sides.push_back(sigma(drive));
    drive.drive(2.0, kQuarter / 2.0);
  }
  drive.drive(6.0, 0.0);
  const double closed = sigma(drive);
  EXPECT_GT(sides[1], 1.3 * sides[0]);
  EXPECT_GT(sides[2], 0.1);
  EXPECT_LT(closed, 0.5 * sides[2]) << "on the first side again";
  EXPECT_GT(closed, 0.015) << "no better than an anchor";
}

/// Once around a square of 80 m, and 10 m on along its first side.
class Return : public testing::Test {
 protected:
  static void go_round(Drive& drive) {
    constexpr double kQuarter = 0.5 * std::numbers::pi;
    drive.match();
    for (int side = 0; side < 4; ++side) {
      drive.drive(80.0, 0.0);
      drive.drive(2.0, kQuarter / 2.0);
    }
    drive.drive(10.0, 0.0);
  }
};

TEST_F(Return, WithoutAGraphItCountsAtOnce) {
  Drive drive;
  go_round(drive);
  EXPECT_LT(sigma(drive), 0.5);
  EXPECT_FALSE(drive.awaits_graph());
}

TEST_F(Return, WhereThePoseIsUncertainItWaitsForTheGraph) {
  Drive drive({}, 30.0);
  go_round(drive);
  EXPECT_GT(sigma(drive), 1.0);
  EXPECT_TRUE(drive.awaits_graph());
  drive.begin_anew(0.02);
  EXPECT_FALSE(drive.awaits_graph());
}

TEST_F(Return, ItWaitsNoFartherThanALoopWouldHaveBeenFound) {
  Drive drive({}, 30.0);
  Drive at_once;
  for (Drive* one : {&drive, &at_once}) {
    go_round(*one);
    one->drive(40.0, 0.0);
  }
  EXPECT_GT(sigma(drive), 1.3 * sigma(at_once));
  for (Drive* one : {&drive, &at_once}) one->drive(20.0, 0.0);
  EXPECT_LT(sigma(drive), 1.05 * sigma(at_once));
}

// A match there that is not expected is no slip of the wheels: the path to it may be wrong by metres.
TEST_F(Return, TheJumpOfAParticleThereWaitsToo) {
  Drive drive({}, 30.0);
  Drive at_once;
  for (Drive* one : {&drive, &at_once}) go_round(*one);
  EXPECT_TRUE(drive.returns_uncertainly(2.0));
  EXPECT_FALSE(drive.returns_uncertainly(-20.0)) << "on the side that it comes from";
  EXPECT_FALSE(at_once.returns_uncertainly(2.0)) << "no graph would find the loop";
  EXPECT_TRUE(drive.awaits_graph());
  drive.drive(30.0, 0.0);
  EXPECT_TRUE(drive.awaits_graph());
  EXPECT_FALSE(drive.returns_uncertainly(2.0)) << "it is rather lost than on a way on which a loop is not found yet";
}

TEST_F(Return, WhatWasSeenAllTheWayIsNoReturn) {
  Drive drive({}, 30.0);
  drive.match();
  // Around a place that it has in view, until it is uncertain by what its wheels say.
  for (int i = 0; i < 40; ++i) drive.drive(4.0, 0.5 * std::numbers::pi);
  EXPECT_FALSE(drive.awaits_graph());
}

TEST(JointBelief, ManyScansOfOnePlaceAreNoBetterThanItsAnchor) {
  JointSettings settings;
  settings.anchor_sigma = 0.05;
  settings.anchor_yaw_sigma = 0.01;
  Drive drive(settings);
  drive.match();
  drive.drive(3.0, 0.0);
  for (int i = 0; i < 500; ++i) drive.match();
  // The error of the anchor, and that of the place.
  EXPECT_GT(std::sqrt(drive.P()(0, 0)), 0.05);
  EXPECT_LT(std::sqrt(drive.P()(0, 0)), 0.10);
  EXPECT_GT(std::sqrt(drive.P()(2, 2)), 0.01);
}

TEST(JointBelief, ALoopGivesItWhatTheGraphOfThePathKnows) {
  Drive drive;
  drive.match();
  drive.drive(40.0, 0.0);
  const std::size_t anchors = drive.anchors();
  ASSERT_GT(anchors, 3U);
  drive.begin_anew(0.5);
  EXPECT_TRUE(drive.has_anchor(1));
  EXPECT_FALSE(drive.has_anchor(2));
  EXPECT_FALSE(drive.has_anchor(anchors - 1));
  // 0.5 rad of the whole map are 20 m here.
  EXPECT_NEAR(std::sqrt(drive.P()(0, 0)), 0.5, 0.02);
  EXPECT_NEAR(std::sqrt(drive.P()(1, 1)), std::hypot(0.5, 20.0), 0.2);
  drive.claim_for_first();
  drive.match();
  EXPECT_LT(sigma(drive), 0.5) << "in a place of an anchor that is known";
}

TEST(JointBelief, ARobotOnItsRoundsAddsNoAnchorsWithoutEnd) {
  constexpr double kQuarter = 0.5 * std::numbers::pi;
  Drive drive;
  drive.match();
  const auto go_round = [&] {
    for (int side = 0; side < 4; ++side) {
      drive.drive(20.0, 0.0);
      drive.drive(2.0, kQuarter / 2.0);
    }
  };
  go_round();
  const std::size_t first = drive.kept_anchors();
  for (int round = 0; round < 20; ++round) go_round();
  EXPECT_LE(drive.kept_anchors(), 2 * first);
}

TEST(JointBelief, ThePlacesOwnErrorCountsWhereNoLandmarksAreInViewAnyMore) {
  JointSettings settings;
  settings.anchor_sigma = 0.5;
  Drive drive(settings);
  drive.match();
  EXPECT_GT(std::sqrt(drive.P()(0, 0)), 0.49);
  drive.see_landmarks(3);
  drive.match();
  EXPECT_LT(std::sqrt(drive.P()(0, 0)), 0.4);
  drive.drive(10.0, 0.0);
  EXPECT_GT(std::sqrt(drive.P()(0, 0)), 0.49);
}

TEST(JointBelief, APoseThatIsGivenIsNoWay) {
  JointSettings settings;
  settings.anchor_sigma = 0.5;
  Drive drive(settings, 30.0);
  drive.match();
  drive.drive(60.0, 0.0);
  drive.match();
  const double before = sigma(drive);
  // It was carried to where it began.
  drive.restart(Eigen::Vector3d::Zero(), 0.1);
  drive.match();
  drive.match();
  EXPECT_FALSE(drive.awaits_graph());
  EXPECT_LT(sigma(drive), 1.1 * before);
}

TEST(JointBelief, TooManyAnchorsAreThinned) {
  JointSettings settings;
  settings.anchor_spacing = 1.0;
  Drive drive(settings);
  drive.match();
  drive.drive(400.0, 0.0);
  EXPECT_GT(drive.anchors(), 200U);
  EXPECT_TRUE(drive.P().allFinite());
  EXPECT_GT(sigma(drive), 0.2);
}

class Standing : public testing::Test {
 protected:
  Standing() : process_(planar(), ProcessNoise{}), joint_(process_, {}, {}, 120) {
    start_.P = ErrorMatrix::Zero(6, 6);
    start_.P(0, 0) = start_.P(1, 1) = 0.01;
  }
  void see(std::vector<Correspondences::Landmark> landmarks) {
    Correspondences seen;
    seen.landmarks = std::move(landmarks);
    joint_.map({.match = {Eigen::Vector3d::Zero(), Eigen::Matrix3d::Zero(), Eigen::Vector3d::Zero()}}, seen, {});
  }
  static Correspondences::Landmark landmark(std::uint64_t birth, bool is_new, double x, double y) {
    return {birth, is_new, {x, y}, 0.04 * Eigen::Matrix2d::Identity()};
  }

  estimation::ProcessModel process_;
  JointBelief joint_;
  Belief start_;
};

TEST_F(Standing, TheCovarianceOfTheFrameIsReported) {
  start_.P.setZero();
  joint_.start(start_, Eigen::Vector3d(0.04, 0.04, 0.01).asDiagonal());
  EXPECT_NEAR(joint_.belief().P(1, 1), 0.04, 1e-12);
  EXPECT_NEAR(joint_.belief().P(2, 2), 0.01, 1e-12);
}

/// They are as uncertain as the pose that saw them, and their detections.
TEST_F(Standing, LandmarksHaveTheirMarginalCovariance) {
  joint_.start(start_, Eigen::Matrix3d::Zero());
  for (int i = 0; i < 100; ++i) see({landmark(7, i == 0, 5.0, 0.0), landmark(8, i == 0, 5.0, 4.0)});
  const auto found = joint_.landmark(7, nullptr);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->P(0, 0), 0.01 + 0.04 / 100.0, 1e-3);
  EXPECT_NEAR(found->p.x(), 5.0, 1e-6);
  EXPECT_FALSE(joint_.landmark(9, nullptr));
}

/// Another particle has the same landmark from another detection; and close to it there is another one.
TEST_F(Standing, ALandmarkOfAnotherBirthIsTheNearestOneThatIsNotSeenBesides) {
  joint_.start(start_, Eigen::Matrix3d::Zero());
  see({landmark(7, true, 5.0, 0.0), landmark(8, true, 5.0, 0.3)});
  see({landmark(8, false, 5.0, 0.3), landmark(70, false, 5.0, 0.16)});
  const auto adopted = joint_.landmark(70, nullptr);
  ASSERT_TRUE(adopted);
  EXPECT_LT(adopted->p.y(), 0.15);
  EXPECT_FALSE(joint_.landmark(7, nullptr));
}

std::vector<Correspondences::Landmark> row(std::uint64_t first, std::uint64_t count, bool is_new) {
  std::vector<Correspondences::Landmark> landmarks;
  for (std::uint64_t i = first; i < first + count; ++i)
    landmarks.push_back({i, is_new, {2.0 * static_cast<double>(i), 3.0}, 0.04 * Eigen::Matrix2d::Identity()});
  return landmarks;
}

TEST_F(Standing, LandmarksThatWereSeenOnceAreForgottenFirst) {
  joint_.start(start_, Eigen::Matrix3d::Zero());
  see(row(1, 60, true));
  see(row(1, 60, false));
  see(row(101, 60, true));
  see(row(201, 40, true));
  EXPECT_EQ(joint_.check(start_).why, "");
  EXPECT_TRUE(joint_.landmark(1, nullptr));
  EXPECT_FALSE(joint_.landmark(101, nullptr));
  EXPECT_TRUE(joint_.landmark(201, nullptr));
}

/// A place of long ago keeps every second landmark or so; where the robot is, all stay.
TEST_F(Standing, LandmarksOfLongAgoAreThinned) {
  joint_.start(start_, Eigen::Matrix3d::Zero());
  for (const bool is_new : {true, false}) see(row(1, 80, is_new));
  for (const bool is_new : {true, false}) see(row(101, 80, is_new));
  EXPECT_EQ(joint_.check(start_).why, "");
  int first = 0;
  int longest_gap = 0;
  int gap = 0;
  for (std::uint64_t i = 1; i <= 80; ++i) {
    const bool is_kept = joint_.landmark(i, nullptr).has_value();
    first += is_kept ? 1 : 0;
    gap = is_kept ? 0 : gap + 1;
    longest_gap = std::max(longest_gap, gap);
    EXPECT_TRUE(joint_.landmark(100 + i, nullptr)) << i;
  }
  EXPECT_EQ(first, 40);
  EXPECT_LE(longest_gap, 3) << "all of the place keeps some";
}

TEST_F(Standing, ItIsGivenUpWhereAScanShowsMoreLandmarksThanThereIsRoomFor) {
  joint_.start(start_, Eigen::Matrix3d::Zero());
  see(row(1, 121, true));
  const JointBelief::Failure failure = joint_.check(start_);
  EXPECT_EQ(failure.why, "a scan shows more than 120 landmarks");
  EXPECT_FALSE(failure.has_begun_anew);
}

/// What a particle associated that is resampled away cannot be taken back here.
TEST_F(Standing, AnAssociationBeyondTheGateHasNoEffect) {
  joint_.start(start_, Eigen::Matrix3d::Zero());
  for (int i = 0; i < 100; ++i) see({landmark(7, i == 0, 5.0, 0.0), landmark(8, i == 0, 5.0, 4.0)});
  see({landmark(7, false, 5.0, 0.0), landmark(8, false, 6.0, 4.0)});  // 5σ
  EXPECT_NEAR(joint_.landmark(8, nullptr)->p.x(), 5.0, 1e-9);
  see({landmark(7, false, 5.0, 0.0), landmark(8, false, 5.5, 4.0)});  // 2.5σ
  EXPECT_GT(joint_.landmark(8, nullptr)->p.x(), 5.001);
}

class Contradicted : public Standing {
 protected:
  Contradicted() {
    joint_.start(start_, Eigen::Matrix3d::Zero());
    particles_ = start_;
  }
  /// Until something happens; a step is one call.
  JointBelief::Failure check(int most) {
    for (steps_ = 1; steps_ <= most; ++steps_) {
      JointBelief::Failure failure = joint_.check(particles_);
      if (!failure.why.empty()) return failure;
    }
    return {};
  }

  Belief particles_;
  int steps_ = 0;
};

TEST_F(Contradicted, ASmallDistanceIsCoveredByTheReport) {
  particles_.mean.T_map_base.p.x() = 0.3;  // 3σ
  EXPECT_EQ(check(100).why, "");
  particles_.mean.T_map_base.p.x() = 0.9;  // 9σ
  EXPECT_EQ(check(100).why, "");
}

TEST_F(Contradicted, LandmarksBeginAnewWithTheDistanceAsUncertainty) {
  see(row(1, 5, true));
  particles_.mean.T_map_base.p.x() = 1.5;
  const JointBelief::Failure failure = check(100);
  EXPECT_EQ(failure.why, "it contradicts the particles by 1.5 m and 0 rad");
  EXPECT_TRUE(failure.has_begun_anew);
  EXPECT_GT(steps_, 10) << "a single step is no contradiction";
  EXPECT_DOUBLE_EQ(joint_.belief().mean.T_map_base.p.x(), 1.5);
  EXPECT_NEAR(joint_.belief().P(0, 0), 0.01 + 1.5 * 1.5, 1e-9);
  EXPECT_NEAR(joint_.belief().P(1, 1), 0.01, 1e-9);
  EXPECT_FALSE(joint_.landmark(1, nullptr)) << "they lie elsewhere in the particles' maps";
  EXPECT_EQ(check(100).why, "");
}

TEST_F(Contradicted, ATornMapOfSurfacesIsGivenUp) {
  Correspondences seen;
  seen.points_base = {{5.0, 0.0}, {5.0, 1.0}};
  joint_.map({.match = {Eigen::Vector3d::Zero(), Eigen::Matrix3d::Zero(), Eigen::Vector3d::Zero()}}, seen, {});
  particles_.mean.T_map_base.p.x() = 1.5;
  const JointBelief::Failure failure = check(100);
  EXPECT_EQ(failure.why, "it contradicts the particles by 1.5 m and 0 rad");
  EXPECT_FALSE(failure.has_begun_anew);
}

}  // namespace
}  // namespace waymark::joint
