// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/evaluation/association_error.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace waymark::evaluation {
namespace {

Time at(double seconds) { return Time{from_seconds(seconds)}; }

/// A robot that stands at (1, 0), heading north, for ten seconds.
Trajectory standing() {
  Trajectory truth{"truth", false, Orientation::yaw, {}};
  for (int t = 0; t <= 10; ++t) truth.points.push_back({at(t), Pose::planar(1.0, 0.0, 1.5707963267948966)});
  return truth;
}

/// A at (1, 5), straight ahead; B at (-1, 5), ahead to the left.
std::vector<Landmark> survey() { return {{"A", {1.0, 5.0}}, {"B", {-1.0, 5.0}}}; }
const Eigen::Vector2d kA(5.0, 0.0);
const Eigen::Vector2d kB(5.0, 2.0);
const Eigen::Vector2d kStone(3.0, -3.0);

Sighting first(double t, const Eigen::Vector2d& p, std::int64_t landmark) { return {at(t), p, landmark, true}; }
Sighting again(double t, const Eigen::Vector2d& p, std::int64_t landmark) { return {at(t), p, landmark, false}; }

AssociationError score(const std::vector<Sighting>& sightings) {
  return score_associations(sightings, standing(), survey(), 0.5, 2);
}

TEST(AssociationError, EverythingRight) {
  const auto s = score({first(0, kA, 7), first(0, kB, 8), again(1, kA, 7), again(1, kB, 8), again(2, kB, 8)});
  EXPECT_EQ(s.correct, 3u);
  EXPECT_EQ(s.wrong, 0u);
  EXPECT_EQ(s.known, 3u);
  EXPECT_EQ(s.found, 3u);
  EXPECT_EQ(s.precision(), 1.0);
  EXPECT_EQ(s.recall(), 1.0);
}

TEST(AssociationError, IntoTheLandmarkOfAnotherThingIsWrong) {
  const auto s = score({first(0, kA, 7), first(0, kB, 8), again(1, kB, 7), again(1, kA, 7), again(2, kB, 8)});
  EXPECT_EQ(s.correct, 2u);
  EXPECT_EQ(s.wrong, 1u);
  EXPECT_EQ(s.known, 3u);
  EXPECT_EQ(s.found, 2u);
  EXPECT_NEAR(s.precision(), 2.0 / 3.0, 1e-12);
}

TEST(AssociationError, ADuplicateIsNotFound) {
  const auto s = score({first(0, kA, 7), again(1, kA, 7), first(2, kA, 9), again(3, kA, 9)});
  EXPECT_EQ(s.correct, 2u);  // 9 stands for A as well
  EXPECT_EQ(s.wrong, 0u);
  EXPECT_EQ(s.known, 3u);
  EXPECT_EQ(s.found, 1u);
}

TEST(AssociationError, WhatWasNeverConfirmedIsNoLandmarkToBeFound) {
  const auto s = score({first(0, kA, 7), first(1, kA, 9), again(2, kA, 9)});
  EXPECT_EQ(s.known, 1u);
  EXPECT_EQ(s.found, 1u);
}

TEST(AssociationError, ClutterIntoALandmarkIsWrongAndClutterByItselfDoesNotCount) {
  const auto s =
      score({first(0, kA, 7), again(1, kStone, 7), first(1, kStone, 9), again(2, kStone, 9), again(2, kA, 7)});
  EXPECT_EQ(s.correct, 1u);
  EXPECT_EQ(s.wrong, 1u);
}

TEST(AssociationError, OutsideOfTheTruthNothingIsScored) {
  const auto s = score({first(-5, kA, 7), again(20, kA, 7)});
  EXPECT_EQ(s.correct + s.wrong + s.known, 0u);
  EXPECT_EQ(s.precision(), 1.0);
}

}  // namespace
}  // namespace waymark::evaluation
