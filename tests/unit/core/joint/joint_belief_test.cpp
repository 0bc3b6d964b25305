// SPDX-License-Identifier: Apache-2.0
#include "joint/joint_belief.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
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
    mean_ = start.mean;
  }

  /// Drives for `seconds` with this turn rate [rad/s], a match every half second.
  void drive(double seconds, double rate) {
    mean_.w_base.z() = rate;
    for (double t = 0.0; t < seconds; t += 0.5) {
      joint_.linearize_at(mean_);
      stamp_ += from_seconds(0.5);
      joint_.predict(stamp_, false);
      process_.predict_mean(mean_, 0.5);
      // Wheels and gyro.
      joint_.replace_twist([](Belief& belief) { belief.P(3, 3) = belief.P(4, 4) = belief.P(5, 5) = 1e-4; });
      match();
    }
  }
  void match() {
    Correspondences seen;
    for (int i = 0; i < 24; ++i) {
      const double angle = i * std::numbers::pi / 12.0;
      seen.points_base.emplace_back(3.0 * std::cos(angle), 3.0 * std::sin(angle));
    }
    joint_.linearize_at(mean_);
    joint_.map({Eigen::Vector3d(1e4, 1e4, 1e5).asDiagonal(), 1.0, true, false}, seen);
  }
  Eigen::Matrix3d P() const { return pose_covariance(joint_.marginal(mean_), planar()); }

 private:
  static ProcessNoise noise() {
    ProcessNoise noise;
    noise.velocity_per_sqrt_s = {0.02, 0.02, 0.0};
    noise.rate_per_sqrt_s = {0.0, 0.0, 0.02};
    return noise;
  }
  estimation::ProcessModel process_;
  JointBelief joint_;
  NavState mean_;
  Time stamp_{};
};

TEST(JointBelief, GrowsInNewGroundAndShrinksWhereTheLoopIsClosed) {
  constexpr double kQuarter = 0.5 * std::numbers::pi;
  Drive drive;
  drive.match();
  std::vector<double> sigma;
  for (int side = 0; side < 4; ++side) {
    drive.drive(20.0, 0.0);
    sigma.push_back(std::sqrt(drive.P()(0, 0) + drive.P()(1, 1)));
    if (side < 3) drive.drive(2.0, kQuarter / 2.0);
  }
  EXPECT_GT(sigma[1], 1.3 * sigma[0]);
  EXPECT_GT(sigma[2], 0.1);
  EXPECT_LT(sigma[3], 0.5 * sigma[2]) << "the start is met again";
  EXPECT_GT(sigma[3], 0.015) << "no better than an anchor";
}

TEST(JointBelief, ManyScansOfOnePlaceAreNoBetterThanItsAnchor) {
  JointSettings settings;
  settings.anchor_sigma = 0.05;
  settings.anchor_yaw_sigma = 0.01;
  Drive drive(settings);
  drive.match();
  drive.drive(3.0, 0.0);
  for (int i = 0; i < 500; ++i) drive.match();
  drive.drive(1.0, 0.0);
  EXPECT_GT(std::sqrt(drive.P()(0, 0)), 0.04);
  EXPECT_LT(std::sqrt(drive.P()(0, 0)), 0.08);
  EXPECT_GT(std::sqrt(drive.P()(2, 2)), 0.008);
}

TEST(JointBelief, TheCovarianceOfTheFrameIsReported) {
  estimation::ProcessModel process(planar(), ProcessNoise{});
  JointBelief joint(process, {});
  Belief start;
  start.P = ErrorMatrix::Zero(6, 6);
  joint.start(start, Eigen::Vector3d(0.04, 0.04, 0.01).asDiagonal());
  NavState far = start.mean;
  far.T_map_base.p.x() = 10.0;  // as if it had driven there without noise
  EXPECT_NEAR(joint.marginal(start.mean).P(1, 1), 0.04, 1e-12);
  EXPECT_NEAR(joint.marginal(far).P(1, 1), 0.04 + 100.0 * 0.01, 1e-9);
}

/// Two landmarks ahead, seen from a robot that stands: they are as uncertain as the pose, and the detections.
TEST(JointBelief, LandmarksHaveTheirMarginalCovariance) {
  estimation::ProcessModel process(planar(), ProcessNoise{});
  JointBelief joint(process, {});
  Belief start;
  start.P = ErrorMatrix::Zero(6, 6);
  start.P(0, 0) = start.P(1, 1) = 0.01;
  joint.start(start, Eigen::Matrix3d::Zero());
  Correspondences seen;
  seen.landmarks.push_back({{5.0, 0.0}, 0.04 * Eigen::Matrix2d::Identity()});
  seen.landmarks.push_back({{5.0, 4.0}, 0.04 * Eigen::Matrix2d::Identity()});
  for (int i = 0; i < 100; ++i) joint.map({Eigen::Matrix3d::Zero(), 1.0, true, false}, seen);
  const auto P = joint.landmark_covariance({5.0, 0.1}, start.mean, std::nullopt);
  ASSERT_TRUE(P);
  EXPECT_NEAR((*P)(0, 0), 0.01 + 0.04 / 100.0, 1e-3);
  EXPECT_FALSE(joint.landmark_covariance({8.0, 0.0}, start.mean, std::nullopt));
}

TEST(JointBelief, TooManyPlacesAreThinned) {
  Drive drive({.anchor_spacing = 1.0});
  drive.drive(400.0, 0.05);
  drive.drive(400.0, 0.0);
  EXPECT_TRUE(drive.P().allFinite());
  EXPECT_GT(drive.P()(0, 0), 0.0);
}

}  // namespace
}  // namespace waymark::joint
