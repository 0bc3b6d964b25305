// SPDX-License-Identifier: Apache-2.0
#include "waymark/interface/nav_state.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "unit/core/beliefs.hpp"
#include "waymark/base/error.hpp"

namespace waymark {
namespace {

using test::block_of;
using ::testing::HasSubstr;
using Motion = StateLayout::Motion;

class Manifold : public ::testing::TestWithParam<Motion> {
 protected:
  const StateLayout layout_{GetParam(), {{"wheels", block_of(2)}, {"gps", block_of(3)}}};
  Random random_ = test::stream(1);

  /// Rotations stay below pi, where the logarithm is unique.
  ErrorVector delta() {
    ErrorVector d = test::normals(layout_.size(), random_);
    const int first = layout_.motion() == Motion::planar ? 2 : 3;
    const int count = layout_.motion() == Motion::planar ? 1 : 3;
    d.segment(first, count) *= 3.0 / std::max(3.0, d.segment(first, count).norm());
    return d;
  }
};

TEST_P(Manifold, MinusGivesBackWhatPlusAdded) {
  for (int i = 0; i < 200; ++i) {
    const NavState before = test::random_state(layout_, random_);
    const ErrorVector d = delta();
    NavState after = before;
    boxplus(after, d, layout_);
    EXPECT_LT((boxminus(after, before, layout_) - d).norm(), 1e-11);
  }
}

TEST_P(Manifold, PlusTheDifferenceLeadsToTheOther) {
  for (int i = 0; i < 200; ++i) {
    const NavState a = test::random_state(layout_, random_);
    NavState b = test::random_state(layout_, random_);
    boxplus(b, boxminus(a, b, layout_), layout_);
    EXPECT_LT((a.T_map_base.p.head<2>() - b.T_map_base.p.head<2>()).norm(), 1e-12);
    EXPECT_LT(a.T_map_base.q.angularDistance(b.T_map_base.q), 1e-7);
    EXPECT_LT((a.v_base - b.v_base).norm() + (a.w_base - b.w_base).norm() + (a.block - b.block).norm(), 1e-12);
  }
}

TEST_P(Manifold, TheQuaternionKeepsUnitLength) {
  NavState state = test::random_state(layout_, random_);
  for (int i = 0; i < 10000; ++i) boxplus(state, delta(), layout_);
  EXPECT_NEAR(state.T_map_base.q.norm(), 1.0, 1e-14);
}

TEST_P(Manifold, TheYawErrorIsTakenAboutTheMapsVertical) {
  NavState state = test::random_state(layout_, random_);
  const Eigen::Matrix3d before = state.T_map_base.q.toRotationMatrix();
  ErrorVector d = ErrorVector::Zero(layout_.size());
  d[layout_.pose_indices()[2]] = 0.4;
  boxplus(state, d, layout_);
  const Eigen::Matrix3d turn = so3::from_rpy(0.0, 0.0, 0.4).toRotationMatrix();
  EXPECT_LT((state.T_map_base.q.toRotationMatrix() - turn * before).norm(), 1e-14);
}

INSTANTIATE_TEST_SUITE_P(Motions, Manifold, ::testing::Values(Motion::planar, Motion::spatial),
                         [](const auto& motion) { return motion.param == Motion::planar ? "Planar" : "Spatial"; });

TEST(BoxPlus, InThePlaneLeavesHeightAndVerticalSpeedAlone) {
  const StateLayout layout(Motion::planar, {});
  NavState state;
  state.T_map_base.p.z() = 7.0;
  state.v_base.z() = 0.5;
  boxplus(state, ErrorVector::Ones(6), layout);
  EXPECT_EQ(state.T_map_base.p, Eigen::Vector3d(1.0, 1.0, 7.0));
  EXPECT_EQ(state.v_base, Eigen::Vector3d(1.0, 1.0, 0.5));
  EXPECT_EQ(state.w_base, Eigen::Vector3d(0.0, 0.0, 1.0));
}

TEST(BoxMinus, TakesTheShortWayAroundTheHalfTurn) {
  const StateLayout layout(Motion::planar, {});
  NavState a;
  NavState b;
  a.T_map_base = Pose::planar(0.0, 0.0, -3.1);
  b.T_map_base = Pose::planar(0.0, 0.0, 3.1);
  EXPECT_NEAR(boxminus(a, b, layout)[2], 2.0 * (std::acos(-1.0) - 3.1), 1e-12);
}

TEST(StateLayout, PlanarKeepsSixCoreStates) {
  const StateLayout layout(Motion::planar, {});
  EXPECT_EQ(layout.core_size(), 6);
  EXPECT_EQ(layout.size(), 6);
  const std::array<int, 12> active = {0, 1, -1, -1, -1, 2, 3, 4, -1, -1, -1, 5};
  for (int i = 0; i < kCoreStates; ++i) EXPECT_EQ(layout.active(i), active[static_cast<std::size_t>(i)]) << i;
  EXPECT_EQ(layout.pose_indices(), (std::array<int, 3>{0, 1, 2}));
}

TEST(StateLayout, SpatialKeepsAllTwelve) {
  const StateLayout layout(Motion::spatial, {});
  EXPECT_EQ(layout.core_size(), 12);
  for (int i = 0; i < kCoreStates; ++i) EXPECT_EQ(layout.active(i), i);
  EXPECT_EQ(layout.pose_indices(), (std::array<int, 3>{0, 1, 5}));
}

TEST(StateLayout, BlocksAreConsecutive) {
  const StateLayout layout(Motion::planar, {{"wheels", block_of(2)}, {"lidar", {}}, {"gps", block_of(3)}});
  EXPECT_EQ(layout.block_size(), 5);
  EXPECT_EQ(layout.size(), 11);
  EXPECT_EQ(layout.block_offset(0), 0);
  EXPECT_EQ(layout.block_offset(1), 2);
  EXPECT_EQ(layout.block_offset(2), 2);
  EXPECT_EQ(layout.block_state(1).name, "state_1");
  EXPECT_EQ(layout.block_state(2).name, "state_0");
}

TEST(StateLayout, TwelveBlockStatesFit) {
  EXPECT_EQ(StateLayout(Motion::spatial, {{"a", block_of(5)}, {"b", block_of(7)}}).size(), kMaxErrorStates);
}

TEST(StateLayout, TooManyBlockStatesListsWhoAskedForHowMany) {
  try {
    const StateLayout layout(Motion::planar, {{"wheels", block_of(6)}, {"lidar", {}}, {"gps", block_of(7)}});
    FAIL() << "nothing was thrown";
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), HasSubstr("need 13 states, at most 12 fit (wheels: 6, gps: 7)"));
  }
}

TEST(PoseCovariance, TakesXYAndYawOutOfTheSpatialState) {
  const StateLayout layout(Motion::spatial, {});
  Random random = test::stream(2);
  Belief belief;
  belief.P = test::random_covariance(layout.size(), random);
  const Eigen::Matrix3d P = pose_covariance(belief, layout);
  EXPECT_EQ(P(0, 1), belief.P(0, 1));
  EXPECT_EQ(P(1, 2), belief.P(1, 5));
  EXPECT_EQ(P(2, 2), belief.P(5, 5));
  EXPECT_EQ(P, P.transpose());
}

}  // namespace
}  // namespace waymark
