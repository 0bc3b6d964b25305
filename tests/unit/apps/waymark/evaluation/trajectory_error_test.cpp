// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/evaluation/trajectory_error.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "waymark/base/error.hpp"

namespace waymark::evaluation {
namespace {

Trajectory::Point point(double t, double x, double y, double yaw = 0.0, double z = 0.0) {
  Pose pose = Pose::planar(x, y, yaw);
  pose.p.z() = z;
  return {Time(from_seconds(t)), pose};
}

Trajectory trajectory(std::vector<Trajectory::Point> points, Orientation orientation = Orientation::none,
                      bool has_z = false) {
  return {.name = "track", .has_z = has_z, .orientation = orientation, .points = std::move(points)};
}

// A bent reference and an estimate that is turned by 0.3 rad, shifted and disturbed; the expected numbers come from an
// independent computation with numpy (SVD after Umeyama).
struct Disturbed {
  Trajectory estimate = trajectory({}, Orientation::none, true);
  Trajectory reference = trajectory({}, Orientation::none, true);

  Disturbed() {
    for (int i = 0; i < 10; ++i) {
      const double x = 2.0 * i;
      const double y = 0.5 * i * i;
      const double z = std::sin(i);
      reference.points.push_back(point(i, x, y, 0.0, z));
      const Eigen::Vector3d p(x + 0.1 * std::sin(3 * i), y + 0.1 * std::cos(2 * i), z + 0.05 * std::cos(5 * i));
      const Eigen::Vector3d moved = so3::from_rpy(0, 0, 0.3) * p + Eigen::Vector3d(5, -3, 1.5);
      estimate.points.push_back(point(i, moved.x(), moved.y(), 0.0, moved.z()));
    }
  }
};

TEST(Statistics, TakesMagnitudes) {
  const ErrorStatistics s = statistics({-3.0, 1.0, 2.0, -4.0});
  EXPECT_DOUBLE_EQ(s.rms, std::sqrt(7.5));
  EXPECT_DOUBLE_EQ(s.mean, 2.5);
  EXPECT_DOUBLE_EQ(s.median, 2.5);
  EXPECT_DOUBLE_EQ(s.max, 4.0);
}

TEST(TrajectoryError, Se2AgreesWithNumpy) {
  const Disturbed d;
  const TrajectoryError e = score_trajectory(d.estimate, d.reference, {.align = Alignment::se2});
  EXPECT_EQ(e.dimensions, 2);
  EXPECT_NEAR(e.T_reference_estimate.yaw(), -0.299136890230, 1e-10);
  EXPECT_NEAR(e.T_reference_estimate.p.x(), -3.886801676436626, 1e-10);
  EXPECT_NEAR(e.T_reference_estimate.p.y(), 4.3265935146566115, 1e-10);
  EXPECT_NEAR(e.position_m.rms, 0.095329720618, 1e-10);
  EXPECT_NEAR(e.position_m.mean, 0.091626899685, 1e-10);
  EXPECT_NEAR(e.position_m.median, 0.091276197790, 1e-10);
  EXPECT_NEAR(e.position_m.max, 0.146586363481, 1e-10);
}

TEST(TrajectoryError, Se3AgreesWithNumpy) {
  const Disturbed d;
  const TrajectoryError e = score_trajectory(d.estimate, d.reference, {.align = Alignment::se3});
  EXPECT_EQ(e.dimensions, 3);
  EXPECT_NEAR(e.T_reference_estimate.yaw(), -0.299180960976, 1e-10);
  EXPECT_NEAR(e.T_reference_estimate.p.z(), -1.5542095289481752, 1e-10);
  EXPECT_NEAR(e.position_m.rms, 0.101223544332, 1e-10);
  EXPECT_NEAR(e.position_m.max, 0.151820223261, 1e-10);
}

TEST(TrajectoryError, WithoutAlignmentAgreesWithNumpy) {
  const Disturbed d;
  EXPECT_NEAR(score_trajectory(d.estimate, d.reference, {}).position_m.rms, 4.722158389776092, 1e-10);
}

TEST(TrajectoryError, ComparesInThePlaneIfTheReferenceHasNoHeight) {
  const auto estimate = trajectory({point(0, 0, 0, 0, 9), point(1, 1, 0, 0, 9)}, Orientation::none, true);
  const auto reference = trajectory({point(0, 0, 1), point(1, 1, 1)});
  const TrajectoryError e = score_trajectory(estimate, reference, {});
  EXPECT_EQ(e.dimensions, 2);
  EXPECT_DOUBLE_EQ(e.position_m.rms, 1.0);
}

TEST(TrajectoryError, SeparatesThePartInThePlane) {
  const auto estimate = trajectory({point(0, 0, 3, 0, 4)}, Orientation::none, true);
  const auto reference = trajectory({point(0, 0, 0)}, Orientation::none, true);
  const TrajectoryError e = score_trajectory(estimate, reference, {});
  EXPECT_DOUBLE_EQ(e.position_m.rms, 5.0);
  EXPECT_DOUBLE_EQ(e.horizontal_m.rms, 3.0);
}

TEST(TrajectoryError, InterpolatesToTheReferencesStamps) {
  const auto estimate = trajectory({point(0, 0, 0, 3.0), point(1, 4, 0, -3.0)}, Orientation::yaw);
  // A quarter of the way from 3 rad to -3 rad lies beyond pi, not near zero.
  const double yaw = 3.0 + 0.25 * (2.0 * std::numbers::pi - 6.0);
  const auto reference = trajectory({point(0.25, 1, 0, yaw)}, Orientation::yaw);
  const TrajectoryError e = score_trajectory(estimate, reference, {});
  EXPECT_NEAR(e.position_m.max, 0.0, 1e-12);
  ASSERT_TRUE(e.yaw_rad);
  EXPECT_NEAR(e.yaw_rad->max, 0.0, 1e-12);
}

TEST(TrajectoryError, CountsWhatItDoesNotScore) {
  const auto estimate = trajectory({point(1, 0, 0), point(1.5, 0, 0), point(4, 0, 0), point(5, 0, 0)});
  const auto reference = trajectory(
      {point(0.5, 0, 0), point(1.2, 0, 0), point(2, 0, 0), point(4, 0, 0), point(4.5, 0, 0), point(6, 0, 0)});
  const TrajectoryError e = score_trajectory(estimate, reference, {});
  EXPECT_EQ(e.reference_points, 6u);
  EXPECT_EQ(e.scored, 3u);
  EXPECT_EQ(e.outside, 2u);
  EXPECT_EQ(e.in_gap, 1u);
  EXPECT_DOUBLE_EQ(e.duration_s, 3.3);
}

TEST(TrajectoryError, PrintsBothSpansIfThereIsNoCommonTime) {
  const auto estimate = trajectory({point(1, 0, 0), point(2, 0, 0)});
  const auto reference = trajectory({point(10, 0, 0), point(20, 0, 0)});
  try {
    score_trajectory(estimate, reference, {});
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), ::testing::AllOf(::testing::HasSubstr("1.000000000 s to 2.000000000 s"),
                                               ::testing::HasSubstr("10.000000000 s to 20.000000000 s")));
  }
}

TEST(TrajectoryError, MovesTheEstimateToTheLeverArm) {
  const auto estimate = trajectory({point(0, 1, 1, 0.5 * std::numbers::pi)}, Orientation::yaw);
  const auto reference = trajectory({point(0, 1.0 - 0.5, 1.0 + 2.0)});
  TrajectoryOptions options;
  EXPECT_NEAR(score_trajectory(estimate, reference, options).position_m.rms, std::hypot(0.5, 2.0), 1e-12);
  options.lever_arm_m = {2.0, 0.5, 0.0};
  EXPECT_NEAR(score_trajectory(estimate, reference, options).position_m.rms, 0.0, 1e-12);
}

TEST(TrajectoryError, RefusesWhatItCannotCompute) {
  const auto flat = trajectory({point(0, 1, 1), point(1, 2, 1), point(2, 2, 2)});
  EXPECT_THROW(score_trajectory(flat, flat, {.lever_arm_m = {1, 0, 0}}), Error);
  EXPECT_THROW(score_trajectory(flat, flat, {.align = Alignment::se3}), Error);
}

TEST(TrajectoryError, YawErrorIsCountedAfterAlignment) {
  Trajectory estimate = trajectory({}, Orientation::yaw);
  Trajectory reference = trajectory({}, Orientation::yaw);
  for (int i = 0; i < 5; ++i) {
    reference.points.push_back(point(i, i, 0, 0));
    const Eigen::Vector3d p = so3::from_rpy(0, 0, 0.4) * Eigen::Vector3d(i, 0, 0);
    estimate.points.push_back(point(i, p.x(), p.y(), 0.4 + 0.02));
  }
  const auto aligned = score_trajectory(estimate, reference, {.align = Alignment::se2});
  EXPECT_NEAR(aligned.yaw_rad->rms, 0.02, 1e-12);
  EXPECT_NEAR(aligned.position_m.max, 0.0, 1e-12);
  EXPECT_NEAR(score_trajectory(estimate, reference, {}).yaw_rad->rms, 0.42, 1e-12);
}

// An odometry that reads 10 % too far and turns 0.01 rad too much per metre, on a straight line.
TEST(RelativeError, SeesDriftPerMetre) {
  Trajectory estimate = trajectory({}, Orientation::yaw);
  Trajectory reference = trajectory({}, Orientation::yaw);
  Pose pose;
  for (int i = 0; i <= 20; ++i) {
    reference.points.push_back(point(i, 0.5 * i, 0, 0));
    estimate.points.push_back({Time(from_seconds(i)), pose});
    pose = pose * Pose::planar(0.55, 0.0, 0.005);
  }
  const RelativeError e = score_trajectory(estimate, reference, {}).relative;
  EXPECT_EQ(e.pairs, 19u);
  EXPECT_NEAR(e.mean_delta, 1.0, 1e-9);
  // Two steps of 0.55 m with 0.005 rad between them, against 1 m straight on.
  const double expected = std::hypot(0.55 + 0.55 * std::cos(0.005) - 1.0, 0.55 * std::sin(0.005));
  EXPECT_NEAR(e.translation_m.rms, expected, 1e-12);
  ASSERT_TRUE(e.rotation_rad);
  EXPECT_NEAR(e.rotation_rad->median, 0.01, 1e-12);
}

TEST(RelativeError, CountsTimeIfAsked) {
  const auto track = trajectory({point(0, 0, 0), point(1, 1, 0), point(2, 4, 0), point(3, 4, 0)});
  const RelativeError e = score_trajectory(track, track, {.rpe_delta_s = 2.0}).relative;
  EXPECT_EQ(e.pairs, 2u);
  EXPECT_DOUBLE_EQ(e.mean_delta, 2.0);
  EXPECT_DOUBLE_EQ(e.translation_m.max, 0.0);
  EXPECT_FALSE(e.rotation_rad);
}

TEST(RelativeError, SkipsPairsFarBeyondTheDelta) {
  const auto track = trajectory({point(0, 0, 0), point(0.5, 10, 0), point(1, 20, 0)});
  EXPECT_EQ(score_trajectory(track, track, {}).relative.pairs, 0u);
}

TEST(RelativeError, IgnoresAConstantOffset) {
  const auto reference = trajectory({point(0, 0, 0, 0.1), point(1, 1, 0, 0.2), point(2, 2, 0, 0.3)}, Orientation::yaw);
  Trajectory estimate = reference;
  for (auto& p : estimate.points) p.pose = Pose::planar(7, -3, 1.2) * p.pose;
  const TrajectoryError e = score_trajectory(estimate, reference, {});
  EXPECT_GT(e.position_m.rms, 1.0);
  EXPECT_NEAR(e.relative.translation_m.max, 0.0, 1e-12);
  EXPECT_NEAR(e.relative.rotation_rad->max, 0.0, 1e-7);
}

}  // namespace
}  // namespace waymark::evaluation
