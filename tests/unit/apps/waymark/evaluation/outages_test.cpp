// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/evaluation/outages.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "waymark/base/error.hpp"

namespace waymark::evaluation {
namespace {

Time at(double seconds) { return Time{from_seconds(seconds)}; }

/// 1 m/s on a circle of radius 20 m, 100 poses a second for 20 s.
Trajectory circle(double from_s = 0.0, double to_s = 20.0) {
  Trajectory trajectory;
  trajectory.name = "a circle";
  trajectory.orientation = Orientation::yaw;
  for (int k = 0; k <= 2000; ++k) {
    const double t = 0.01 * k;
    if (t < from_s - 1e-9 || t > to_s + 1e-9) continue;
    const double angle = t / 20.0;
    const Pose pose = Pose::planar(20.0 * std::sin(angle), 20.0 - 20.0 * std::cos(angle), angle);
    trajectory.points.push_back({at(t), pose});
  }
  return trajectory;
}

/// What drifts away along x at 0.1 m/s from second 5 to 10, and then steps back at once.
Trajectory sawtooth() {
  Trajectory trajectory = circle();
  for (Trajectory::Point& point : trajectory.points) {
    const double t = to_seconds(point.stamp.time_since_epoch());
    if (t > 5.0 && t < 10.0) point.pose.p.x() += 0.1 * (t - 5.0);
  }
  return trajectory;
}

std::vector<PoseCovariance> covariances(double sigma_x, double sigma_y) {
  std::vector<PoseCovariance> all;
  for (int k = 0; k <= 200; ++k)
    all.push_back({at(0.1 * k), Eigen::Vector3d(sigma_x * sigma_x, sigma_y * sigma_y, 0.01).asDiagonal()});
  return all;
}

const std::vector<Outage> kOutage{{at(5.0), at(10.0)}};

TEST(Outages, TellsTheErrorAtTheEndTheLargestAndTheStepBack) {
  const auto score = score_outages(kOutage, sawtooth(), circle(), covariances(0.25, 0.1), Pose{}, {});
  ASSERT_EQ(score.size(), 1u);
  const OutageError& one = score.front();
  EXPECT_NEAR(*one.position_end_m, 0.5, 1e-3);
  EXPECT_NEAR(*one.position_max_m, 0.5, 1e-3);
  EXPECT_NEAR(*one.sigma_end_m, 0.25, 1e-12);
  EXPECT_NEAR(*one.error_end_sigma, 2.0, 1e-2);
  EXPECT_NEAR(*one.step_m, 0.5, 2e-3);
  EXPECT_NEAR(*one.step_sigma, 2.0, 2e-2);
  EXPECT_NEAR(*one.yaw_end_rad, 0.0, 1e-6);
}

TEST(Outages, AnErrorThatPassesIsTheLargestAndNotTheOneAtTheEnd) {
  Trajectory estimate = circle();
  for (Trajectory::Point& point : estimate.points) {
    const double t = to_seconds(point.stamp.time_since_epoch());
    if (t > 5.0 && t < 9.0) point.pose.p.y() += std::sin(0.25 * std::numbers::pi * (t - 5.0));
  }
  const OutageError one = score_outages(kOutage, estimate, circle(), {}, Pose{}, {}).front();
  EXPECT_NEAR(*one.position_max_m, 1.0, 1e-3);
  EXPECT_NEAR(*one.position_end_m, 0.0, 1e-3);
}

TEST(Outages, AnEstimateWithoutFaultDoesNotStep) {
  const OutageError one = score_outages(kOutage, circle(), circle(), {}, Pose{}, {}).front();
  EXPECT_LT(*one.step_m, 1e-6) << "the robot's own motion counts as a step";
  EXPECT_LT(*one.position_max_m, 1e-6);
  EXPECT_FALSE(one.sigma_end_m.has_value());
  EXPECT_FALSE(one.step_sigma.has_value());
}

TEST(Outages, TheLargestStepIsFoundAlsoIfItIsNotTheFirst) {
  Trajectory estimate = circle();
  for (Trajectory::Point& point : estimate.points) {
    const double t = to_seconds(point.stamp.time_since_epoch());
    if (t > 9.995) point.pose.p.x() += 0.1;
    if (t > 10.995) point.pose.p.x() += 0.4;
    if (t > 12.5) point.pose.p.x() += 9.0;  // beyond the two seconds
  }
  const OutageError one = score_outages(kOutage, estimate, circle(), {}, Pose{}, {}).front();
  EXPECT_NEAR(*one.step_m, 0.4, 1e-3);
}

TEST(Outages, TheStepNeedsNoTruthAndTheErrorDoes) {
  const OutageError one =
      score_outages(kOutage, sawtooth(), circle(0.0, 6.0), covariances(0.25, 0.1), Pose{}, {}).front();
  EXPECT_FALSE(one.position_end_m.has_value());
  EXPECT_NEAR(*one.position_max_m, 0.1, 2e-3) << "of the part that is known";
  EXPECT_NEAR(*one.step_m, 0.5, 2e-3);
}

TEST(Outages, TheAlignmentTurnsErrorsAndCovariances) {
  const Pose turn = Pose::planar(3.0, -2.0, 0.5 * std::numbers::pi);
  Trajectory estimate = sawtooth();
  for (auto& point : estimate.points) point.pose = turn.inverse() * point.pose;
  // In the estimate's own frame the reference's x is its y, backwards.
  const OutageError one = score_outages(kOutage, estimate, circle(), covariances(0.1, 0.25), turn, {}).front();
  EXPECT_NEAR(*one.position_end_m, 0.5, 1e-3);
  EXPECT_NEAR(*one.error_end_sigma, 2.0, 1e-2);
  EXPECT_NEAR(*one.step_sigma, 2.0, 2e-2);
}

TEST(Outages, TheReferenceMayBeAnAntenna) {
  Trajectory antenna = circle();
  for (auto& point : antenna.points) point.pose.p = point.pose * Eigen::Vector3d(0.5, 0.2, 0.0);
  OutageOptions options;
  options.lever_arm_m = {0.5, 0.2, 0.0};
  EXPECT_LT(*score_outages(kOutage, circle(), antenna, {}, Pose{}, options).front().position_end_m, 1e-5);
  EXPECT_GT(*score_outages(kOutage, circle(), antenna, {}, Pose{}, {}).front().position_end_m, 0.5);
}

TEST(Outages, PausesAreFound) {
  Trajectory recording = circle();
  std::erase_if(recording.points, [](const Trajectory::Point& point) {
    const double t = to_seconds(point.stamp.time_since_epoch());
    return (t > 3.0 && t < 5.0) || (t > 8.0 && t < 13.0);
  });
  const auto found = pauses(recording, 2.5);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(to_seconds(found[0].begin.time_since_epoch()), 8.0, 0.011);
  EXPECT_NEAR(to_seconds(found[0].end.time_since_epoch()), 13.0, 0.011);
  EXPECT_EQ(pauses(recording, 1.0).size(), 2u);
}

TEST(Outages, AreReadAsBeginAndEnd) {
  const Outage outage = parse_outage("30:45.5");
  EXPECT_EQ(outage.begin, at(30.0));
  EXPECT_EQ(outage.end, at(45.5));
  for (const char* wrong : {"30", "45:30", "30:30", "a:b", "", "30:"}) {
    try {
      parse_outage(wrong);
      FAIL() << wrong;
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("30:45"));
    }
  }
}

}  // namespace
}  // namespace waymark::evaluation
