// SPDX-License-Identifier: Apache-2.0
#include "loops/keyframes.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "unit/core/beliefs.hpp"

namespace waymark::loops {
namespace {

std::vector<Keyframe> keyframes(int count) {
  std::vector<Keyframe> all;
  for (int i = 0; i < count; ++i) {
    Keyframe keyframe;
    keyframe.stamp = test::at(i);
    keyframe.xyyaw = {-1.0, -1.0, 0.0};
    all.push_back(std::move(keyframe));
  }
  return all;
}

TEST(Keyframes, FollowAPathBetweenItsStamps) {
  std::vector<Keyframe> followers = keyframes(4);
  follow(followers, std::vector<StampedPose>{{test::at(1), Pose::planar(1.0, 0.0, 0.0)},
                                             {test::at(1.5), Pose::planar(2.0, 0.0, 0.0)},
                                             {test::at(2.5), Pose::planar(4.0, 0.0, 0.5)}});
  EXPECT_DOUBLE_EQ(followers[0].xyyaw.x(), -1.0) << "before the path it stays";
  EXPECT_DOUBLE_EQ(followers[1].xyyaw.x(), 1.0);
  EXPECT_DOUBLE_EQ(followers[2].xyyaw.x(), 3.0);
  EXPECT_DOUBLE_EQ(followers[2].xyyaw.z(), 0.25);
  EXPECT_DOUBLE_EQ(followers[3].xyyaw.x(), 4.0) << "after the path it has its last pose";
}

TEST(Keyframes, FollowTheRestOfAPathAsTheyWouldFollowAllOfIt) {
  std::vector<StampedPose> path;
  for (int i = 0; i < 20; ++i) path.push_back({test::at(0.7 * i), Pose::planar(i, 0.1 * i * i, 0.01 * i)});
  std::vector<Keyframe> in_parts = keyframes(12);
  follow(in_parts, std::span(path).first(9));
  follow(in_parts, std::span(path).subspan(8));
  std::vector<Keyframe> at_once = keyframes(12);
  follow(at_once, path);
  for (std::size_t i = 0; i < at_once.size(); ++i) EXPECT_EQ(in_parts[i].xyyaw, at_once[i].xyyaw) << i;
}

}  // namespace
}  // namespace waymark::loops
