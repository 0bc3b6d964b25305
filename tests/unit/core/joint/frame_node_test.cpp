// SPDX-License-Identifier: Apache-2.0
#include "joint/frame_node.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>

#include "estimation/state_jacobian.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::joint {
namespace {

constexpr double kTilt = 0.02;  // σ of roll and pitch at the start [rad]

/// A robot of spatial motion that begins a map at the origin, with a height that is known and a tilt that is not.
class FrameNodeTest : public ::testing::Test {
 protected:
  FrameNodeTest() {
    Belief start;
    start.P = ErrorMatrix::Zero(layout_.size(), layout_.size());
    start.P.diagonal().segment<2>(3).setConstant(kTilt * kTilt);
    gaussian_.start(start);
    frame_.begin(gaussian_);
  }

  /// The robot moves by (x, y), and knows badly where to, nor how it stands then.
  void drive(double x, double y) {
    gaussian_.add_noise([&](Belief& belief) { belief.mean.T_map_base.p += Eigen::Vector3d(x, y, 0.0); });
    gaussian_.add_noise([](Belief& belief) {
      belief.P.diagonal().head<3>().array() += 100.0;
      belief.P.diagonal().segment<3>(3).array() += 1e-2;
    });
  }
  /// A match that finds the robot where the belief has it.
  void match() {
    const SpatialMatrix information = 1e8 * SpatialMatrix::Identity();
    frame_.relate(gaussian_, {gaussian_.belief().mean.T_map_base, {information, SpatialVector::Zero()}});
  }
  /// Gravity: roll and pitch with this σ, as they are believed.
  void level(double sigma) {
    Linearization model;
    model.reset(2, 0);
    model.R = sigma * sigma * Eigen::Matrix2d::Identity();
    estimation::StateJacobian H;
    H.reset(2, layout_.size());
    H.add(3, Eigen::Vector2d::UnitX());
    H.add(4, Eigen::Vector2d::UnitY());
    gaussian_.update(model, H);
  }
  double sigma(int state) const { return std::sqrt(gaussian_.belief().P(state, state)); }

  const StateLayout layout_{StateLayout::Motion::spatial, {}};
  JointGaussian gaussian_{layout_};
  FrameNode frame_;
};

TEST_F(FrameNodeTest, AMatchSaysNothingAboutHowTheMapStandsToGravity) {
  drive(0.0, 0.0);
  for (int scan = 0; scan < 50; ++scan) match();
  EXPECT_NEAR(sigma(3), kTilt, 0.01 * kTilt);
  EXPECT_NEAR(sigma(4), kTilt, 0.01 * kTilt);
  EXPECT_LT(sigma(2), 1e-3) << "the height at the map's origin is that of the start";
}

TEST_F(FrameNodeTest, ATiltOfTheMapIsAHeightFarAway) {
  drive(20.0, 0.0);
  match();
  EXPECT_NEAR(sigma(2), 20.0 * kTilt, 0.01 * 20.0 * kTilt);
}

TEST_F(FrameNodeTest, GravityLevelsTheMapAndWithItTheHeightFarAway) {
  drive(20.0, 0.0);
  match();
  level(1e-3);
  match();
  EXPECT_NEAR(sigma(4), 1e-3, 1e-4);
  EXPECT_NEAR(sigma(2), 20.0 * 1e-3, 2e-3);
}

TEST_F(FrameNodeTest, AMapThatWasLoadedIsCertain) {
  FrameNode loaded;
  drive(20.0, 0.0);
  loaded.relate(gaussian_,
                {gaussian_.belief().mean.T_map_base, {1e8 * SpatialMatrix::Identity(), SpatialVector::Zero()}});
  EXPECT_LT(sigma(2), 1e-3);
  EXPECT_LT(sigma(3), 1e-3);
}

TEST_F(FrameNodeTest, AMatchMovesTheRobotWithinTheMap) {
  drive(5.0, 3.0);
  SpatialVector off;
  off << 0.0, 0.0, 0.05, 0.01, -0.02, 0.0;
  const Pose before = gaussian_.belief().mean.T_map_base;
  const SpatialMatrix information = 1e8 * SpatialMatrix::Identity();
  frame_.relate(gaussian_, {before, {information, information * off}});
  const Pose& after = gaussian_.belief().mean.T_map_base;
  const Eigen::Vector3d turn = so3::log(after.q * before.q.conjugate());
  // The start's tilt shares what the robot's own large noise leaves.
  EXPECT_NEAR(after.p.z() - before.p.z(), 0.05, 0.01);
  EXPECT_NEAR(turn.x(), 0.01, 2e-3);
  EXPECT_NEAR(turn.y(), -0.02, 2e-3);
}

}  // namespace
}  // namespace waymark::joint
