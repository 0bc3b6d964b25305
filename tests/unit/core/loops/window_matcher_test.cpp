// SPDX-License-Identifier: Apache-2.0
#include "loops/window_matcher.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace waymark::loops {
namespace {

using Points = std::vector<Eigen::Vector2f>;

void add_wall(Points& points, const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  const double length = (to - from).norm();
  for (double s = 0.0; s < length; s += 0.07) points.emplace_back((from + s / length * (to - from)).cast<float>());
}

/// A room with a niche: it fits in one place only.
Points room() {
  Points points;
  add_wall(points, {-4.0, -3.0}, {6.0, -3.0});
  add_wall(points, {6.0, -3.0}, {6.0, 2.0});
  add_wall(points, {6.0, 2.0}, {1.0, 2.0});
  add_wall(points, {1.0, 2.0}, {1.0, 5.0});
  add_wall(points, {-4.0, 5.0}, {-4.0, -3.0});
  return points;
}

/// The points as they look from `pose`.
Points seen_from(const Points& points, const Eigen::Vector3d& pose) {
  Points seen;
  for (const Eigen::Vector2f& p : points) {
    const Eigen::Vector2d at = p.cast<double>();
    seen.emplace_back(compose(inverse(pose), {at.x(), at.y(), 0.0}).head<2>().cast<float>());
  }
  return seen;
}

TEST(WindowMatcher, FindsARoomFarFromThePrior) {
  WindowMatcher matcher;
  matcher.draw(room());
  const Eigen::Vector3d truth(2.3, -1.1, 0.4);
  const auto match = matcher.match(seen_from(room(), truth), {-1.0, 1.0, 0.3}, {6.0, 0.3}).match;
  ASSERT_TRUE(match);
  EXPECT_LT((match->relation.z - truth).head<2>().norm(), 0.03);
  EXPECT_NEAR(match->relation.z.z(), truth.z(), 0.005);
  EXPECT_GT(match->score, 0.8);
}

TEST(WindowMatcher, FindsNothingWhereTheRoomIsAnother) {
  WindowMatcher matcher;
  matcher.draw(room());
  Points other;
  add_wall(other, {-2.0, -2.0}, {2.0, 2.0});
  add_wall(other, {2.0, 2.0}, {5.0, -4.0});
  add_wall(other, {-6.0, 0.0}, {-2.0, 5.0});
  const WindowSearch search = matcher.match(other, Eigen::Vector3d::Zero(), {3.0, 0.2});
  EXPECT_FALSE(search.match);
  EXPECT_FALSE(search.is_ambiguous);
}

TEST(WindowMatcher, ACorridorSaysNothingAlong) {
  Points corridor;
  add_wall(corridor, {-25.0, -1.0}, {25.0, -1.0});
  add_wall(corridor, {-25.0, 1.0}, {25.0, 1.0});
  WindowMatcher matcher;
  matcher.draw(corridor);
  Points part;
  add_wall(part, {-8.0, -1.0}, {8.0, -1.0});
  add_wall(part, {-8.0, 1.0}, {8.0, 1.0});
  const auto match = matcher.match(part, {0.1, 0.05, 0.01}, {0.45, 0.05}).match;
  ASSERT_TRUE(match);
  EXPECT_GT(match->relation.P(0, 0), 0.25);
  EXPECT_LT(match->relation.P(1, 1), 0.01);
  EXPECT_NEAR(match->relation.z.y(), 0.0, 0.05);
}

// Identical rooms side by side: the search reaches both, and nothing says which it is.
TEST(WindowMatcher, RefusesAPlaceThatAnotherOneRivals) {
  Points rooms;
  Points one;
  add_wall(one, {-2.0, -2.0}, {2.0, -2.0});
  add_wall(one, {-2.0, 2.0}, {2.0, 2.0});
  add_wall(one, {-2.0, -2.0}, {-2.0, 1.0});
  add_wall(one, {2.0, -2.0}, {2.0, 1.0});
  for (const double x : {-6.0, 0.0, 6.0}) {
    for (const Eigen::Vector2f& p : one) rooms.emplace_back(p + Eigen::Vector2f(static_cast<float>(x), 0.0f));
  }
  WindowMatcher matcher;
  matcher.draw(rooms);
  const WindowSearch search = matcher.match(one, {0.0, 0.0, 0.0}, {7.0, 0.1});
  EXPECT_FALSE(search.match);
  EXPECT_TRUE(search.is_ambiguous);
  EXPECT_TRUE(matcher.match(one, {0.0, 0.0, 0.0}, {2.0, 0.1}).match);
}

}  // namespace
}  // namespace waymark::loops
