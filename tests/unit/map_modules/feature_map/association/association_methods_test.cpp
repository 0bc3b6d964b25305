// SPDX-License-Identifier: Apache-2.0
#include "map_modules/feature_map/association/association_methods.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "map_modules/feature_map/association/pose_refinement.hpp"
#include "tests/unit/map_modules/feature_map/feature_map_bench.hpp"

namespace waymark::feature_map {
namespace {

using feature_map_test::detection_of;
using feature_map_test::gaussian_at;
using feature_map_test::landmark_at;
using feature_map_test::observation_of;
using feature_map_test::settings_of;

/// Sixteen landmarks, more than any table here has columns; where they stand does not matter.
const LandmarkStore& some_landmarks() {
  static const LandmarkStore store = [] {
    LandmarkStore all;
    for (int n = 0; n < 16; ++n) all.add(landmark_at(n, 0.0));
    return all;
  }();
  return store;
}

/// Pairs by hand: log likelihood of (detection, landmark); -infinity where there is none.
FeatureAssociation pairs_of(const Eigen::MatrixXd& log_likelihood) {
  FeatureAssociation association;
  association.landmark_of.assign(static_cast<std::size_t>(log_likelihood.rows()), LandmarkRef{});
  association.nearby.gather(some_landmarks(), {0.0, 0.0}, 1000.0);
  for (int d = 0; d < log_likelihood.rows(); ++d) {
    for (int n = 0; n < log_likelihood.cols(); ++n) {
      if (std::isfinite(log_likelihood(d, n))) association.pairs.push_back({log_likelihood(d, n), d, n});
    }
  }
  return association;
}

/// Per detection the landmark, or -1.
std::vector<int> landmarks_of(const FeatureAssociation& association) {
  std::vector<int> landmarks;
  for (const LandmarkRef ref : association.landmark_of) landmarks.push_back(ref.chunk < 0 ? -1 : ref.place);
  return landmarks;
}

constexpr double kNone = -std::numeric_limits<double>::infinity();

TEST(AssociationMethods, GreedyTakesTheLikeliestPairFirst) {
  Eigen::Matrix2d log_likelihood;
  log_likelihood << 3.0, 2.0, 2.5, kNone;
  FeatureAssociation association = pairs_of(log_likelihood);
  associate_greedily(association);
  EXPECT_EQ(landmarks_of(association), (std::vector<int>{0, -1}));
}

TEST(AssociationMethods, OptimalTakesTheGreatestSum) {
  Eigen::Matrix2d log_likelihood;
  log_likelihood << 3.0, 2.0, 2.5, kNone;
  FeatureAssociation association = pairs_of(log_likelihood);
  associate_optimally(-5.0, association);
  EXPECT_EQ(landmarks_of(association), (std::vector<int>{1, 0}));
}

TEST(AssociationMethods, OptimalLeavesADetectionNewWhereThatIsLikelier) {
  Eigen::Matrix2d log_likelihood;
  log_likelihood << 3.0, -4.9, 2.5, kNone;
  FeatureAssociation association = pairs_of(log_likelihood);
  associate_optimally(-4.0, association);  // 3 − 4 is more than −4.9 + 2.5 only with the second detection new
  EXPECT_EQ(landmarks_of(association), (std::vector<int>{0, -1}));
}

TEST(AssociationMethods, OptimalIsTheBestOfAllAssignments) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> likelihood(-4.0, 4.0);
  std::bernoulli_distribution exists(0.5);
  constexpr double kLogP0 = -4.0;
  for (int k = 0; k < 200; ++k) {
    const Eigen::MatrixXd table =
        Eigen::MatrixXd::NullaryExpr(4, 4, [&] { return exists(random) ? likelihood(random) : kNone; });
    FeatureAssociation association = pairs_of(table);
    associate_optimally(kLogP0, association);
    double found = 0.0;
    const std::vector<int> landmarks = landmarks_of(association);
    for (int d = 0; d < 4; ++d) {
      const int n = landmarks[static_cast<std::size_t>(d)];
      found += n < 0 ? kLogP0 : table(d, n);
    }
    double best = kNone;
    for (int code = 0; code < 625; ++code) {  // each detection one of four landmarks or none
      double sum = 0.0;
      int used = 0;
      for (int d = 0, rest = code; d < 4; ++d, rest /= 5) {
        const int n = rest % 5;
        sum += n == 4 ? kLogP0 : (used & (1 << n)) != 0 ? kNone : table(d, n);
        if (n < 4) used |= 1 << n;
      }
      best = std::max(best, sum);
    }
    EXPECT_NEAR(found, best, 1e-9);
  }
}

TEST(AssociationMethods, AloneInTheSceneAllAgree) {
  LandmarkStore store;
  const auto id = store.add(landmark_at(5.0, 0.0));
  for (const char* method : {"greedy", "optimal"}) {
    FeatureAssociation association;
    Refinement refinement;
    associate_and_refine<2>(
        store, settings_of(std::string("{ negative_information: false, association: { method: ") + method + " } }"),
        0.5, gaussian_at(Eigen::Vector3d::Zero(), Eigen::Vector3d(0.01, 0.01, 0.0).asDiagonal()),
        observation_of(
            {detection_of({5.05, 0.0}, Eigen::Vector3d::Zero()), detection_of({0.0, 9.0}, Eigen::Vector3d::Zero())}),
        association, refinement);
    ASSERT_GE(association.landmark_of[0].chunk, 0) << method;
    EXPECT_EQ(store.at(association.landmark_of[0]).id, id) << method;
    EXPECT_EQ(association.landmark_of[1].chunk, FeatureAssociation::kNew) << method;
  }
}

}  // namespace
}  // namespace waymark::feature_map
