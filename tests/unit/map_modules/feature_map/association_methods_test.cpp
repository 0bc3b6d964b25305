// SPDX-License-Identifier: Apache-2.0
#include "association_methods.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "feature_map_bench.hpp"

namespace waymark {
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
  association.match.assign(static_cast<std::size_t>(log_likelihood.rows()), LandmarkRef{});
  association.nearby.gather(some_landmarks(), {0.0, 0.0}, 1000.0);
  for (int d = 0; d < log_likelihood.rows(); ++d) {
    for (int n = 0; n < log_likelihood.cols(); ++n) {
      if (std::isfinite(log_likelihood(d, n))) association.pairs.push_back({log_likelihood(d, n), 0.0, d, n});
    }
  }
  return association;
}

/// Per detection the landmark, or -1.
std::vector<int> landmarks_of(const FeatureAssociation& association) {
  std::vector<int> landmarks;
  for (const LandmarkRef ref : association.match) landmarks.push_back(ref.chunk < 0 ? -1 : ref.place);
  return landmarks;
}

constexpr double kNone = -std::numeric_limits<double>::infinity();

TEST(AssociationMethods, GreedyTakesTheLikeliestPairFirst) {
  Eigen::Matrix2d log_likelihood;
  log_likelihood << 3.0, 2.0, 2.5, kNone;
  FeatureAssociation association = pairs_of(log_likelihood);
  match_greedily(association);
  EXPECT_EQ(landmarks_of(association), (std::vector<int>{0, -1}));
}

TEST(AssociationMethods, OptimalTakesTheGreatestSum) {
  Eigen::Matrix2d log_likelihood;
  log_likelihood << 3.0, 2.0, 2.5, kNone;
  FeatureAssociation association = pairs_of(log_likelihood);
  match_optimally(-5.0, association);
  EXPECT_EQ(landmarks_of(association), (std::vector<int>{1, 0}));
}

TEST(AssociationMethods, OptimalLeavesADetectionNewWhereThatIsLikelier) {
  Eigen::Matrix2d log_likelihood;
  log_likelihood << 3.0, -4.9, 2.5, kNone;
  FeatureAssociation association = pairs_of(log_likelihood);
  match_optimally(-4.0, association);  // 3 − 4 is more than −4.9 + 2.5 only with the second detection new
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
    match_optimally(kLogP0, association);
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

/// A row of pillars 0.6 m apart, seen from a pose whose heading is off by nearly one pillar.
struct RowOfPillars {
  LandmarkStore store;
  FeatureObservation observation;
  Eigen::Matrix3d P = Eigen::Vector3d(1e-4, 1e-4, 0.01).asDiagonal();

  RowOfPillars() {
    std::vector<Detection> detections;
    for (int i = 0; i < 4; ++i) {
      store.add(landmark_at(6.0, 0.6 * i, 0.02));
      detections.push_back(detection_of({6.0, 0.6 * i}, {0.0, 0.0, 0.055}, 0.03));
    }
    store.add(landmark_at(6.0, -0.45, 0.02));  // the one that a wrong match of the first detection would take
    observation = observation_of(std::move(detections));
  }

  std::vector<std::int64_t> ids(const std::string& method, const std::string& more = "") const {
    FeatureAssociation association;
    Refinement refinement;
    match_and_refine<2>(store,
                        settings_of("{ negative_information: false, association: { method: " + method + more + " } }"),
                        0.5, gaussian_at(Eigen::Vector3d::Zero(), P), observation, association, refinement);
    std::vector<std::int64_t> ids;
    for (const LandmarkRef ref : association.match) ids.push_back(ref.chunk < 0 ? -1 : store.at(ref).id);
    return ids;
  }
};

TEST(AssociationMethods, JointSeesThatAllAreOffByTheSameTurn) {
  const RowOfPillars row;
  EXPECT_EQ(row.ids("joint"), (std::vector<std::int64_t>{0, 1, 2, 3}));
  EXPECT_NE(row.ids("greedy"), (std::vector<std::int64_t>{0, 1, 2, 3})) << "a row that no method gets wrong";
}

TEST(AssociationMethods, JointStaysWithinItsNodes) {
  const RowOfPillars row;
  // Five nodes are one way to the first leaf: all detections with their likeliest landmarks, none shared.
  std::vector<std::int64_t> ids = row.ids("joint", ", joint_max_nodes: 5");
  ids.erase(std::remove(ids.begin(), ids.end(), -1), ids.end());
  std::sort(ids.begin(), ids.end());
  EXPECT_EQ(std::adjacent_find(ids.begin(), ids.end()), ids.end());
}

TEST(AssociationMethods, AloneInTheSceneAllAgree) {
  LandmarkStore store;
  const auto id = store.add(landmark_at(5.0, 0.0));
  for (const char* method : {"greedy", "optimal", "joint"}) {
    FeatureAssociation association;
    Refinement refinement;
    match_and_refine<2>(
        store, settings_of(std::string("{ negative_information: false, association: { method: ") + method + " } }"),
        0.5, gaussian_at(Eigen::Vector3d::Zero(), Eigen::Vector3d(0.01, 0.01, 0.0).asDiagonal()),
        observation_of(
            {detection_of({5.05, 0.0}, Eigen::Vector3d::Zero()), detection_of({0.0, 9.0}, Eigen::Vector3d::Zero())}),
        association, refinement);
    ASSERT_GE(association.match[0].chunk, 0) << method;
    EXPECT_EQ(store.at(association.match[0]).id, id) << method;
    EXPECT_EQ(association.match[1].chunk, FeatureAssociation::kNew) << method;
  }
}

}  // namespace
}  // namespace waymark
