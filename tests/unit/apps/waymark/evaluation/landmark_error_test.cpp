// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/evaluation/landmark_error.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>
#include <random>

#include "apps/waymark/evaluation/assignment.hpp"
#include "apps/waymark/evaluation/report.hpp"

namespace waymark::evaluation {
namespace {

Landmark landmark(std::string name, double x, double y, double radius = std::numeric_limits<double>::quiet_NaN(),
                  int sightings = 100) {
  return {.name = std::move(name), .p_map = {x, y}, .radius_m = radius, .sightings = sightings};
}

struct Value {
  int pairs;
  double cost;
};

Value value_of(const Eigen::MatrixXd& cost, const std::vector<int>& columns, double limit) {
  Value v{0, 0.0};
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (columns[i] < 0) continue;
    const double c = cost(static_cast<Eigen::Index>(i), columns[i]);
    if (c > limit) return {-1, 0.0};
    ++v.pairs;
    v.cost += c;
  }
  return v;
}

// Every way to give rows distinct columns or none.
Value best_by_trying(const Eigen::MatrixXd& cost, double limit, std::vector<int>& columns) {
  const auto row = static_cast<Eigen::Index>(columns.size());
  if (row == cost.rows()) return value_of(cost, columns, limit);
  Value best{-1, 0.0};
  for (int c = -1; c < cost.cols(); ++c) {
    if (c >= 0 && (std::find(columns.begin(), columns.end(), c) != columns.end() || cost(row, c) > limit)) continue;
    columns.push_back(c);
    const Value v = best_by_trying(cost, limit, columns);
    columns.pop_back();
    if (v.pairs > best.pairs || (v.pairs == best.pairs && v.cost < best.cost)) best = v;
  }
  return best;
}

TEST(Assign, EqualsTryingEverything) {
  std::mt19937 generator(7);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (int round = 0; round < 200; ++round) {
    Eigen::MatrixXd cost(1 + round % 5, 1 + round / 5 % 5);
    for (Eigen::Index i = 0; i < cost.size(); ++i) cost(i) = uniform(generator);
    const double limit = 0.2 + 0.6 * uniform(generator);
    std::vector<int> none;
    const Value expected = best_by_trying(cost, limit, none);
    const std::vector<int> columns = assign(cost, limit);
    const Value found = value_of(cost, columns, limit);
    EXPECT_EQ(found.pairs, expected.pairs) << "round " << round;
    EXPECT_NEAR(found.cost, expected.cost, 1e-9) << "round " << round;
    std::vector<int> used;
    std::copy_if(columns.begin(), columns.end(), std::back_inserter(used), [](int c) { return c >= 0; });
    std::sort(used.begin(), used.end());
    EXPECT_EQ(std::adjacent_find(used.begin(), used.end()), used.end()) << "a column is used twice";
  }
}

TEST(Assign, TakesMorePairsThanGreedy) {
  Eigen::MatrixXd cost(2, 2);
  cost << 0.1, 0.4, 0.5, 9.0;
  EXPECT_EQ(assign(cost, 0.6), (std::vector<int>{1, 0}));
}

TEST(Assign, CopesWithNothing) {
  EXPECT_EQ(assign(Eigen::MatrixXd(2, 0), 1.0), (std::vector<int>{-1, -1}));
  EXPECT_TRUE(assign(Eigen::MatrixXd(0, 3), 1.0).empty());
}

TEST(LandmarkError, CountsByHand) {
  const std::vector<Landmark> survey{landmark("A", 0, 0, 0.2), landmark("B", 10, 0, 0.3), landmark("C", 0, 10)};
  const std::vector<Landmark> map{landmark("1", 0.3, 0, 0.25), landmark("2", 10, 0.4, 0.2), landmark("3", 0, 0.5),
                                  landmark("4", 5, 5), landmark("5", 0, 10, 0.1, 9)};
  const LandmarkError e = score_landmarks(map, survey, Pose(), {});
  EXPECT_EQ(e.surveyed, 3u);
  EXPECT_EQ(e.counted, 4u);
  EXPECT_EQ(e.too_few_sightings, 1u);
  EXPECT_EQ(e.matched, 2u);
  EXPECT_EQ(e.duplicates, 1u);
  EXPECT_EQ(e.others, 1u);
  EXPECT_EQ(e.missed, std::vector<std::string>{"C"});
  ASSERT_TRUE(e.position_m);
  EXPECT_NEAR(e.position_m->rms, std::sqrt((0.09 + 0.16) / 2), 1e-12);
  EXPECT_NEAR(e.position_m->max, 0.4, 1e-12);
  ASSERT_TRUE(e.radius_m);
  EXPECT_NEAR(e.radius_m->rms, std::sqrt((0.0025 + 0.01) / 2), 1e-12);
  EXPECT_NEAR(*e.radius_bias_m, -0.025, 1e-12);
}

TEST(LandmarkError, MovesTheMapByTheTrajectorysAlignment) {
  const std::vector<Landmark> survey{landmark("A", 5, 1), landmark("B", 5, 3)};
  const std::vector<Landmark> map{landmark("1", 0, 0), landmark("2", 2, 0)};
  EXPECT_EQ(score_landmarks(map, survey, Pose(), {}).matched, 0u);
  const LandmarkError e = score_landmarks(map, survey, Pose::planar(5, 1, 0.5 * std::numbers::pi), {});
  EXPECT_EQ(e.matched, 2u);
  EXPECT_NEAR(e.position_m->max, 0.0, 1e-12);
}

// The map is turned by 2 degrees: at first only what is near the centre matches, after the first fit the rest does.
TEST(LandmarkError, OwnAlignmentMatchesAgainUntilItConverges) {
  const double turn = 2.0 * std::numbers::pi / 180.0;
  std::vector<Landmark> survey;
  std::vector<Landmark> map;
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector3d p(2.5 * i, i % 3, 0.0);
    const Eigen::Vector3d q = so3::from_rpy(0, 0, turn) * p;
    survey.push_back(landmark(std::to_string(i), p.x(), p.y()));
    map.push_back(landmark(std::to_string(i), q.x(), q.y()));
  }
  const LandmarkError e = score_landmarks(map, survey, Pose(), {});
  EXPECT_LT(e.matched, 10u);
  ASSERT_TRUE(e.own_alignment);
  EXPECT_EQ(e.own_alignment->matched, 20u);
  EXPECT_NEAR(e.own_alignment->T_survey_map.yaw(), -turn, 1e-9);
  EXPECT_NEAR(e.own_alignment->position_m.rms, 0.0, 1e-9);
}

TEST(LandmarkError, HoldsTheCovariancesAgainstTheErrors) {
  Landmark near = landmark("1", 0.1, 0.2);  // (0.1 / 0.1)² + (0.2 / 0.4)²
  near.P = Eigen::Matrix2d(Eigen::Vector2d(0.01, 0.16).asDiagonal());
  Landmark far = landmark("2", 4.0, 0.5);  // (0.5 / 0.1)²
  far.P = Eigen::Matrix2d(0.01 * Eigen::Matrix2d::Identity());
  const std::vector<Landmark> survey = {landmark("A", 0, 0), landmark("B", 4, 0), landmark("C", 9, 0)};
  const LandmarkError e = score_landmarks({near, far, landmark("3", 9, 0.1)}, survey, Pose(), {});
  ASSERT_TRUE(e.consistency);
  EXPECT_NEAR(e.consistency->nees.mean, 0.5 * (1.25 + 25.0), 1e-9);
  EXPECT_NEAR(e.consistency->share_within_95, 0.5, 1e-12);

  // Turned by a right angle, its east is the survey's north.
  near.p_map = {0.1, 0.0};
  const LandmarkError turned =
      score_landmarks({near}, {landmark("A", 0, 0)}, Pose::planar(0.0, 0.0, 1.5707963267948966), {});
  EXPECT_NEAR(turned.consistency->nees.mean, 1.0, 1e-9);
  EXPECT_FALSE(score_landmarks({landmark("3", 9, 0.1)}, survey, Pose(), {}).consistency);
}

TEST(LandmarkError, HasNoOwnAlignmentWithOneMatch) {
  const LandmarkError e = score_landmarks({landmark("1", 0, 0)}, {landmark("A", 0, 0)}, Pose(), {});
  EXPECT_EQ(e.matched, 1u);
  EXPECT_FALSE(e.own_alignment);
}

TEST(LandmarkError, CopesWithAnEmptyMap) {
  const LandmarkError e = score_landmarks({}, {landmark("A", 0, 0)}, Pose(), {});
  EXPECT_EQ(e.matched, 0u);
  EXPECT_EQ(e.missed, std::vector<std::string>{"A"});
  EXPECT_FALSE(e.position_m);
}

TEST(EvaluationReport, JsonHoldsTheNumbers) {
  Report report;
  report.landmarks = score_landmarks({landmark("1", 0.3, 0), landmark("2", 4, 0)},
                                     {landmark("A", 0, 0), landmark("B", 4, 0.1)}, Pose(), {});
  const auto json = nlohmann::json::parse(to_json(report));
  EXPECT_TRUE(json.at("trajectory").is_null());
  EXPECT_EQ(json.at("landmarks").at("matched"), 2);
  EXPECT_NEAR(json.at("landmarks").at("landmark_rms_m").get<double>(), std::sqrt(0.05), 1e-12);
  EXPECT_TRUE(json.at("landmarks").at("landmark_rms_own_alignment_m").is_number());
  EXPECT_TRUE(json.at("landmarks").at("radius_rms_m").is_null());
}

TEST(EvaluationReport, TextNamesTheMissed) {
  Report report;
  report.landmarks = score_landmarks({}, {landmark("north gate", 0, 0)}, Pose(), {});
  EXPECT_NE(to_text(report).find("north gate"), std::string::npos);
}

}  // namespace
}  // namespace waymark::evaluation
