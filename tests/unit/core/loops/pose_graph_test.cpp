// SPDX-License-Identifier: Apache-2.0
#include "loops/pose_graph.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include "loops/twist.hpp"
#include "waymark/math/gaussian.hpp"
#include "waymark/math/random.hpp"

namespace waymark::loops {
namespace {

/// Nodes once around a square of 20 m, one a metre; the last is where the first is.
std::vector<Eigen::Vector3d> square() {
  std::vector<Eigen::Vector3d> poses{Eigen::Vector3d::Zero()};
  for (int side = 0; side < 4; ++side) {
    for (int i = 0; i < 20; ++i) {
      const double turn = i == 19 ? std::numbers::pi / 2.0 : 0.0;
      poses.push_back(compose(poses.back(), {1.0, 0.0, turn}));
    }
  }
  return poses;
}

struct Path {
  std::vector<Eigen::Vector3d> truth = square();
  std::vector<Relation> steps;
  std::vector<Eigen::Vector3d> reckoned{Eigen::Vector3d::Zero()};

  explicit Path(std::uint64_t seed) {
    Random random({seed, 0, 0, 0});
    const Eigen::Matrix3d P = Eigen::Vector3d(0.03, 0.03, 0.01).cwiseAbs2().asDiagonal();
    for (std::size_t k = 0; k + 1 < truth.size(); ++k) {
      steps.push_back({between(truth[k], truth[k + 1]) + gaussian::sample(P, random), P});
      reckoned.push_back(compose(reckoned.back(), steps.back().z));
    }
  }
  double error(const std::vector<Eigen::Vector3d>& poses) const {
    double sum = 0.0;
    for (std::size_t k = 0; k < poses.size(); ++k) sum += (poses[k] - truth[k]).head<2>().squaredNorm();
    return std::sqrt(sum / static_cast<double>(poses.size()));
  }
  Loop loop(std::size_t from, std::size_t to) const {
    return {from, to, {between(truth[from], truth[to]), 0.0025 * Eigen::Matrix3d::Identity()}};
  }
};

TEST(PlanarRelations, AreInvertedAndComposed) {
  const Relation ab{{1.0, 2.0, 0.5}, Eigen::Vector3d(0.04, 0.09, 0.01).asDiagonal()};
  const Relation identity = compose(ab, {inverse(ab.z), Eigen::Matrix3d::Zero()});
  EXPECT_LT(identity.z.norm(), 1e-12);
  const Relation back = inverse(inverse(ab));
  EXPECT_LT((back.z - ab.z).norm(), 1e-12);
  EXPECT_LT((back.P - ab.P).norm(), 1e-12);
}

// The covariance of an inverse and of a chain, by draws.
TEST(PlanarRelations, HaveTheCovarianceOfDraws) {
  Random random({7, 0, 0, 0});
  const Eigen::Matrix3d P = 1e-4 * (Eigen::Matrix3d() << 4.0, 1.0, 0.5, 1.0, 2.0, 0.2, 0.5, 0.2, 1.0).finished();
  const Relation ab{{3.0, -1.0, 0.8}, P};
  const Relation bc{{0.5, 2.0, -0.3}, 2.0 * P};
  const Relation chain = compose(ab, bc);
  const Relation back = inverse(ab);
  Eigen::Matrix3d of_chain = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d of_inverse = Eigen::Matrix3d::Zero();
  constexpr int kDraws = 20000;
  for (int i = 0; i < kDraws; ++i) {
    const Eigen::Vector3d first = ab.z + gaussian::sample(ab.P, random);
    const Eigen::Vector3d second = bc.z + gaussian::sample(bc.P, random);
    const Eigen::Vector3d d = compose(first, second) - chain.z;
    const Eigen::Vector3d e = inverse(first) - back.z;
    of_chain += d * d.transpose() / kDraws;
    of_inverse += e * e.transpose() / kDraws;
  }
  EXPECT_LT((of_chain - chain.P).norm(), 0.05 * chain.P.norm());
  EXPECT_LT((of_inverse - back.P).norm(), 0.05 * back.P.norm());
}

TEST(PoseGraph, ALoopCorrectsThePathBetween) {
  double before = 0.0;
  double after = 0.0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Path path(seed);
    const std::vector<Loop> loops{path.loop(0, 80)};
    std::vector<Eigen::Vector3d> poses = path.reckoned;
    PoseGraph(path.steps, loops).solve(poses);
    EXPECT_LT((poses.back() - poses.front()).head<2>().norm(), 0.1) << seed;
    before += path.error(path.reckoned);
    after += path.error(poses);
  }
  EXPECT_LT(after, 0.5 * before);
}

TEST(PoseGraph, ANewLoopPullsFromFarOff) {
  Path path(1);
  // A turn that was missed by 0.3 rad: the end is several metres off.
  path.steps[20].z.z() += 0.3;
  path.steps[20].P(2, 2) = 0.1;
  for (std::size_t k = 0; k + 1 < path.truth.size(); ++k)
    path.reckoned[k + 1] = compose(path.reckoned[k], path.steps[k].z);
  ASSERT_GT((path.reckoned.back() - path.reckoned.front()).head<2>().norm(), 4.0);
  const std::vector<Loop> loops{path.loop(0, 78), path.loop(1, 79), path.loop(0, 80)};
  std::vector<Eigen::Vector3d> poses = path.reckoned;
  PoseGraph(path.steps, loops).solve(poses);
  EXPECT_LT((poses.back() - poses.front()).head<2>().norm(), 0.1);
}

TEST(PoseGraph, ALoopThatContradictsAllElseLosesItsWeight) {
  const Path path(2);
  std::vector<Loop> loops{path.loop(0, 80), path.loop(1, 79), path.loop(3, 78), path.loop(10, 40)};
  loops.back().relation.z.x() += 6.0;
  std::vector<Eigen::Vector3d> poses = path.reckoned;
  PoseGraph(path.steps, loops).solve(poses);
  loops.pop_back();
  std::vector<Eigen::Vector3d> without = path.reckoned;
  PoseGraph(path.steps, loops).solve(without);
  for (std::size_t k = 0; k < poses.size(); ++k) EXPECT_LT((poses[k] - without[k]).norm(), 0.1) << k;
}

TEST(PoseGraph, TheUncertaintyOfAWayUsesLoops) {
  const Path path(3);
  const auto alone = PoseGraph(path.steps, {}).relations_from(79);
  const std::vector<Loop> loops{path.loop(0, 80)};
  const auto closed = PoseGraph(path.steps, loops).relations_from(79);
  EXPECT_LT(closed[1].P.trace(), 0.1 * alone[1].P.trace());
  EXPECT_LT(closed[79].P.norm(), 1e-12);
}

/// A straight way of four metres to the east, and how well it is known.
class Way : public testing::Test {
 protected:
  Way() {
    for (int k = 0; k <= 4; ++k) poses_.emplace_back(k, 0.0, 0.0);
    steps_.assign(4, {{1.0, 0.0, 0.0}, Eigen::Vector3d(kAlong, kAcross, kTurn).asDiagonal()});
  }
  /// Of (x, y, yaw) of one node.
  Eigen::Matrix3d covariance(std::size_t node, std::span<const Loop> loops) const {
    const std::vector<std::size_t> nodes{node};
    const Eigen::Matrix3d T = error_of_twist(poses_[node].head<2>());
    return T * PoseGraph(steps_, loops).covariance(poses_, nodes) * T.transpose();
  }

  static constexpr double kAlong = 0.01;
  static constexpr double kAcross = 0.02;
  static constexpr double kTurn = 0.03;
  std::vector<Eigen::Vector3d> poses_;
  std::vector<Relation> steps_;
};

TEST_F(Way, TheErrorsOfItsStepsAddUpAndTurnsHaveALever) {
  const Eigen::Matrix3d P = covariance(4, {});
  EXPECT_NEAR(P(0, 0), 4.0 * kAlong, 1e-6);
  EXPECT_NEAR(P(1, 1), 4.0 * kAcross + (9.0 + 4.0 + 1.0) * kTurn, 1e-5);
  EXPECT_NEAR(P(1, 2), (3.0 + 2.0 + 1.0) * kTurn, 1e-5);
  EXPECT_NEAR(P(2, 2), 4.0 * kTurn, 1e-6);
  EXPECT_TRUE(covariance(0, {}).isZero());
}

TEST_F(Way, ALoopLeavesABridge) {
  const std::vector<Loop> loops{{0, 4, {poses_[4], 1e-7 * Eigen::Matrix3d::Identity()}}};
  EXPECT_LT(covariance(4, loops).norm(), 1e-6);
  // Half of the way there and half of it back.
  EXPECT_NEAR(covariance(2, loops)(0, 0), kAlong, 1e-5);
}

TEST_F(Way, PlacesThatAreWrongTogetherAreCorrelated) {
  const std::vector<std::size_t> nodes{3, 4, 0};
  const Eigen::MatrixXd P = PoseGraph(steps_, {}).covariance(poses_, nodes);
  ASSERT_EQ(P.rows(), 9);
  // What has moved the earlier one has moved the later one.
  EXPECT_LT((P.block<3, 3>(0, 3) - P.block<3, 3>(0, 0)).norm(), 1e-12);
  EXPECT_TRUE(P.bottomRows(3).isZero());
}

TEST_F(Way, ALoopThatLostItsWeightSaysNothing) {
  const std::vector<Loop> loops{
      {0, 4, {poses_[4] + Eigen::Vector3d(5.0, 0.0, 0.0), 1e-4 * Eigen::Matrix3d::Identity()}}};
  EXPECT_NEAR(covariance(4, loops)(0, 0), 4.0 * kAlong, 1e-3);
}

TEST(AgreeingLoops, LeaveOutTheOneThatDoesNotFit) {
  const Path path(4);
  std::vector<Loop> loops{path.loop(0, 76), path.loop(1, 78), path.loop(2, 79), path.loop(3, 80)};
  loops[1].relation.z.y() += 2.0;
  EXPECT_EQ(agreeing(loops, path.steps), (std::vector<std::size_t>{0, 2, 3}));
}

}  // namespace
}  // namespace waymark::loops
