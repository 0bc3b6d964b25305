// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/run_views/reference_frame.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace waymark::run_views {
namespace {

/// A drive along an arc; the reference is this in its own frame.
struct Drive {
  explicit Drive(const Pose& T_reference_map, double drift_per_s = 0.0) {
    for (int i = 0; i <= 100; ++i) {
      const Time stamp{from_seconds(0.1 * i)};
      const double angle = 0.02 * i;
      const Pose T = Pose::planar(10.0 * std::sin(angle), 10.0 - 10.0 * std::cos(angle), angle);
      reference.trajectory.push_back({stamp, T_reference_map * T, true});
      Pose estimate = T;
      estimate.p.x() += drift_per_s * 0.1 * i;
      estimates.push_back({stamp, estimate, 0.05, 0.01});
    }
  }
  Reference reference;
  std::vector<Estimate> estimates;
};

TEST(ReferenceFrame, OfTheSameFrameIsLeftAsItIs) {
  const Drive drive{Pose()};
  EXPECT_FALSE(frame_of(drive.reference, drive.estimates).is_aligned);
}

TEST(ReferenceFrame, OfAnotherFrameIsFitted) {
  const Drive drive{Pose::planar(100.0, -40.0, 1.2)};
  const ReferenceFrame frame = frame_of(drive.reference, drive.estimates);
  ASSERT_TRUE(frame.is_aligned);
  for (std::size_t i = 0; i < drive.estimates.size(); ++i) {
    const Pose T = frame.T_map_reference * drive.reference.trajectory[i].T_map_base;
    EXPECT_LT((T.p - drive.estimates[i].T_map_base.p).norm(), 1e-6);
  }
}

TEST(ReferenceFrame, AnEstimateThatDriftsFromACommonStartIsNotHidden) {
  const Drive drive(Pose(), 0.8);
  EXPECT_FALSE(frame_of(drive.reference, drive.estimates).is_aligned);
}

TEST(ReferenceFrame, WithoutACommonTimeNothingIsFitted) {
  Drive drive{Pose::planar(100.0, -40.0, 1.2)};
  for (Estimate& estimate : drive.estimates) estimate.stamp += std::chrono::hours(1);
  EXPECT_FALSE(frame_of(drive.reference, drive.estimates).is_aligned);
}

TEST(ReferenceLookup, IsOnTheLineBetweenTwoPointsAndNotInAPause) {
  Reference reference;
  for (const double t : {0.0, 0.1, 0.2, 0.3, 30.0})
    reference.trajectory.push_back({Time{from_seconds(t)}, Pose::planar(10.0 * t, 0.0, 0.0), true});
  const ReferenceLookup lookup(reference);
  ASSERT_TRUE(lookup.at(Time{from_seconds(0.15)}));
  EXPECT_NEAR(lookup.at(Time{from_seconds(0.15)})->p.x(), 1.5, 1e-9);
  EXPECT_FALSE(lookup.at(Time{from_seconds(10.0)}));
  EXPECT_FALSE(lookup.at(Time{from_seconds(31.0)}));
  EXPECT_TRUE(lookup.is_pause(3));
  EXPECT_FALSE(lookup.is_pause(2));
}

}  // namespace
}  // namespace waymark::run_views
