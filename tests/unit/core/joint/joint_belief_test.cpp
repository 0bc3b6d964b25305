// SPDX-License-Identifier: Apache-2.0
#include "joint/joint_belief.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace waymark::joint {
namespace {

const StateLayout& planar() {
  static const StateLayout layout(StateLayout::Motion::planar, {});
  return layout;
}

/// A robot at 1 m/s whose heading drifts, with a precise scanner of short reach: it sees its own surroundings.
class Drive {
 public:
  explicit Drive(const JointSettings& settings = {}) : process_(planar(), noise()), joint_(process_, settings) {
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
    for (int i = 0; i < 24; ++i) {
      const double angle = i * std::numbers::pi / 12.0;
      seen.points_base.emplace_back(3.0 * std::cos(angle), 3.0 * std::sin(angle));
    }
    // The particle is where the Gaussian has it: the match confirms that.
    const Pose pose = joint_.belief().mean.T_map_base;
    const Eigen::Vector3d xyyaw(pose.p.x(), pose.p.y(), pose.yaw());
    const PoseMatch match{xyyaw, Eigen::Vector3d(1e4, 1e4, 1e5).asDiagonal(), Eigen::Vector3d::Zero()};
    if (const auto added = joint_.map({.match = match, .T_map_base = pose}, seen, anchors_))
      anchors_.push_back({*added, xyyaw});
  }
  Eigen::Matrix3d P() const { return pose_covariance(joint_.belief(), planar()); }
  std::size_t anchors() const { return anchors_.size(); }

 private:
  static ProcessNoise noise() {
    ProcessNoise noise;
    noise.velocity_per_sqrt_s = {0.02, 0.02, 0.0};
    noise.rate_per_sqrt_s = {0.0, 0.0, 0.02};
    return noise;
  }
  estimation::ProcessModel process_;
  JointBelief joint_;
  std::vector<AnchorPose> anchors_;
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
  Standing() : process_(planar(), ProcessNoise{}), joint_(process_, {}, 120) {
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

TEST_F(Standing, ItIsGivenUpWhereThereIsNoRoomForTheLandmarks) {
  joint_.start(start_, Eigen::Matrix3d::Zero());
  const auto row = [](std::uint64_t first, bool is_new) {
    std::vector<Correspondences::Landmark> landmarks;
    for (std::uint64_t i = first; i < first + 100; ++i)
      landmarks.push_back(landmark(i, is_new, 2.0 * static_cast<double>(i), 3.0));
    return landmarks;
  };
  see(row(1, true));
  see(row(101, true));
  EXPECT_EQ(joint_.failure(start_), "") << "the oldest that were seen once are left out";
  see(row(101, false));
  see(row(201, true));
  EXPECT_NE(joint_.failure(start_).find("more than 120 landmarks"), std::string::npos) << joint_.failure(start_);
}

TEST_F(Standing, ItIsGivenUpWhereItContradictsTheParticles) {
  joint_.start(start_, Eigen::Matrix3d::Zero());
  Belief particles = start_;
  particles.mean.T_map_base.p.x() = 0.3;  // 3σ
  for (int i = 0; i < 100; ++i) EXPECT_EQ(joint_.failure(particles), "");
  particles.mean.T_map_base.p.x() = 0.9;  // 9σ, which the report covers
  for (int i = 0; i < 100; ++i) EXPECT_EQ(joint_.failure(particles), "");
  particles.mean.T_map_base.p.x() = 1.5;
  std::string failure;
  int steps = 0;
  while (failure.empty() && ++steps < 100) failure = joint_.failure(particles);
  EXPECT_NE(failure.find("contradicts the particles by 1.5 m"), std::string::npos) << failure;
  EXPECT_GT(steps, 10) << "a single step is no contradiction";
}

}  // namespace
}  // namespace waymark::joint
