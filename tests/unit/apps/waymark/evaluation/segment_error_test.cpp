// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/evaluation/segment_error.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace waymark::evaluation {
namespace {

/// A straight drive at 10 m/s with a pose every 0.1 s; the estimate is longer by `scale` and turns by `turn` rad per m.
std::vector<PosePair> drive(double length_m, double scale, double turn) {
  std::vector<PosePair> pairs;
  for (int i = 0; i <= static_cast<int>(length_m); ++i) {
    pairs.push_back({Time{from_seconds(0.1 * i)}, Pose::planar(scale * i, 0.0, turn * i), Pose::planar(i, 0.0, 0.0)});
  }
  return pairs;
}

TEST(SegmentErrors, OfAPathShorterThanTheShortestSegmentThereAreNone) {
  EXPECT_EQ(score_segments(drive(99, 1.0, 0.0)).all.segments, 0u);
  EXPECT_TRUE(score_segments({}).by_length.empty());
}

TEST(SegmentErrors, AScaleErrorIsTheShareOfTheLength) {
  const SegmentErrors e = score_segments(drive(250, 1.02, 0.0));
  ASSERT_EQ(e.by_length.size(), 2u);
  EXPECT_NEAR(e.by_length[0].translation, 0.02, 1e-9);
  EXPECT_NEAR(e.by_length[1].translation, 0.02, 1e-9);
  EXPECT_NEAR(e.all.translation, 0.02, 1e-9);
  EXPECT_NEAR(e.all.rotation_rad_per_m, 0.0, 1e-9);
}

TEST(SegmentErrors, BeginEverySecond) {
  // 10 m apart: from 0, 10, …, 150 m there are 100 m left, from 0, …, 50 m there are 200 m.
  const SegmentErrors e = score_segments(drive(250, 1.0, 0.0));
  ASSERT_EQ(e.by_length.size(), 2u);
  EXPECT_EQ(e.by_length[0].segments, 16u);
  EXPECT_EQ(e.by_length[1].segments, 6u);
  EXPECT_EQ(e.all.segments, 22u);
}

TEST(SegmentErrors, ATurnCountsPerMetre) {
  const SegmentErrors e = score_segments(drive(150, 1.0, 1e-4));
  ASSERT_EQ(e.by_length.size(), 1u);
  EXPECT_NEAR(e.by_length[0].rotation_rad_per_m, 1e-4, 1e-9);
}

}  // namespace
}  // namespace waymark::evaluation
