// SPDX-License-Identifier: Apache-2.0
#include "estimation/new_start.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "unit/core/beliefs.hpp"

namespace waymark {
namespace {

using Motion = StateLayout::Motion;
using estimation::begin_anew;
using estimation::is_sound;

class NewStartOf : public ::testing::TestWithParam<Motion> {
 protected:
  Belief random_belief() {
    return {test::at(100.0), test::random_state(layout, random), test::random_covariance(layout.size(), random)};
  }
  /// At (7, 8) with a heading of 1 rad, an hour later.
  estimation::NewStart start() const {
    estimation::NewStart start;
    start.prior.stamp = test::at(3700.0);
    start.prior.mean.T_map_base = Pose::planar(7.0, 8.0, 1.0);
    start.prior.mean.block.setZero(layout.block_size());
    start.prior.P.setZero(layout.size(), layout.size());
    start.prior.P.diagonal().head(layout.core_size()).setConstant(0.25);
    return start;
  }

  StateLayout layout{
      GetParam(),
      {{"wheels", {{"scale", 0.0, 0.5, 1e-3}}},
       {"gyro", {{"bias", 0.0, 0.1, 0.0, 0.0, 60.0, 0.05}}},
       {"georeference", estimation::Georeference::block(GetParam(), GeoreferenceSettings{true, 0.0, 0.0})}}};
  std::optional<estimation::Georeference> georeference{std::in_place, layout, 2};
  Random random = test::stream(97);
};

TEST_P(NewStartOf, PoseAndTwistAreThoseOfTheStart) {
  Belief belief = random_belief();
  begin_anew(belief, start(), layout, std::nullopt);
  EXPECT_EQ(belief.stamp, test::at(3700.0));
  EXPECT_NEAR(belief.mean.T_map_base.p.x(), 7.0, 1e-12);
  EXPECT_NEAR(belief.mean.T_map_base.yaw(), 1.0, 1e-9);
  EXPECT_EQ(belief.mean.v_base, Eigen::Vector3d::Zero());
  EXPECT_TRUE(belief.P.topRightCorner(layout.core_size(), layout.block_size()).isZero());
  EXPECT_TRUE(is_sound(belief));
}

TEST_P(NewStartOf, TheSensorsOwnStatesGrowAsPredictedButNotBeyondTheirFirstSigma) {
  Belief belief = random_belief();
  belief.mean.block[0] = 0.3;
  belief.mean.block[1] = 0.2;
  belief.P = 1e-4 * ErrorMatrix::Identity(layout.size(), layout.size());
  Belief years = belief;
  begin_anew(belief, start(), layout, std::nullopt);
  const int first = layout.core_size();
  EXPECT_EQ(belief.mean.block[0], 0.3);
  EXPECT_NEAR(belief.P(first, first), 1e-4 + 3600.0 * 1e-6, 1e-12);
  EXPECT_NEAR(belief.mean.block[1], 0.0, 1e-12) << "a Gauss-Markov state is forgotten";
  EXPECT_NEAR(belief.P(first + 1, first + 1), 0.0025, 1e-9);
  estimation::NewStart later = start();
  later.prior.stamp = test::at(1.6e9);
  begin_anew(years, later, layout, std::nullopt);
  EXPECT_NEAR(years.P(first, first), 0.25, 1e-12);
}

TEST_P(NewStartOf, TheLastPoseCanBeKept) {
  Belief belief = random_belief();
  const Pose before = belief.mean.T_map_base;
  estimation::NewStart kept = start();
  kept.keeps_pose = true;
  begin_anew(belief, kept, layout, georeference);
  EXPECT_EQ(belief.mean.T_map_base.p, before.p);
  EXPECT_EQ(belief.P(0, 0), 0.25);
}

TEST_P(NewStartOf, WithAGeoreferenceThePoseOnTheEarthIsThatOfTheStart) {
  Belief belief = random_belief();
  const ErrorMatrix blocks = belief.P.bottomRightCorner(3, 3);
  begin_anew(belief, start(), layout, georeference);
  EXPECT_TRUE(is_sound(belief));
  EXPECT_TRUE(belief.P.bottomRightCorner(3, 3).isApprox(blocks)) << "the map stays where it is";
  georeference->to_enu(belief);
  EXPECT_NEAR(belief.mean.T_map_base.p.x(), 7.0, 1e-9);
  EXPECT_NEAR(belief.mean.T_map_base.p.y(), 8.0, 1e-9);
  EXPECT_NEAR(belief.mean.T_map_base.yaw(), 1.0, 1e-9);
  const Eigen::Matrix3d expected = 0.25 * Eigen::Matrix3d::Identity();
  EXPECT_TRUE(pose_covariance(belief, layout).isApprox(expected, 1e-6)) << pose_covariance(belief, layout);
}

/// Covariances that are none.
std::vector<ErrorMatrix> awful(int size, Random& random) {
  const ErrorMatrix good = test::random_covariance(size, random);
  std::vector<ErrorMatrix> all(7, good);
  all[0](2, 2) = std::nan("");
  all[1](0, 0) = std::numeric_limits<double>::infinity();
  all[2](1, 1) = -1e-3;
  all[3] *= 1e27;  // fifty years of acceleration
  all[4](0, 2) = all[4](2, 0) = 2.0 * std::sqrt(good(0, 0) * good(2, 2));
  all[5].setConstant(-1.0);
  all[6](size - 1, 0) = all[6](0, size - 1) = std::nan("");
  return all;
}

TEST_P(NewStartOf, AnAwfulCovarianceIsDetectedAndReplaced) {
  Belief belief = random_belief();
  EXPECT_TRUE(is_sound(belief));
  int index = 0;
  for (const ErrorMatrix& P : awful(layout.size(), random)) {
    Belief broken = belief;
    broken.P = P;
    EXPECT_FALSE(is_sound(broken)) << index;
    begin_anew(broken, start(), layout, georeference);
    EXPECT_TRUE(is_sound(broken)) << index << "\n" << broken.P;
    EXPECT_LT(test::asymmetry(broken.P), 1e-9) << index;
    ++index;
  }
}

TEST_P(NewStartOf, AMeanThatIsNoNumberIsReplaced) {
  for (const bool keeps_pose : {true, false}) {
    Belief broken = random_belief();
    broken.mean.T_map_base.p.setConstant(std::nan(""));
    broken.mean.block.setConstant(std::nan(""));
    EXPECT_FALSE(is_sound(broken));
    estimation::NewStart at = start();
    at.keeps_pose = keeps_pose;
    begin_anew(broken, at, layout, georeference);
    EXPECT_TRUE(is_sound(broken));
  }
}

TEST_P(NewStartOf, AStateWithoutVarianceIsSound) {
  Belief belief = random_belief();
  belief.P.row(1).setZero();
  belief.P.col(1).setZero();
  EXPECT_TRUE(is_sound(belief));
  belief.P(1, 1) = -1e-15;  // a rounding error
  EXPECT_TRUE(is_sound(belief));
}

INSTANTIATE_TEST_SUITE_P(Motions, NewStartOf, ::testing::Values(Motion::planar, Motion::spatial),
                         [](const auto& motion) { return motion.param == Motion::planar ? "planar" : "spatial"; });

}  // namespace
}  // namespace waymark
