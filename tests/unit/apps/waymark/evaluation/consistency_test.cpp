// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/evaluation/consistency.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "temporary_folder.hpp"
#include "waymark/base/error.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::evaluation {
namespace {

Time at(double seconds) { return Time{from_seconds(seconds)}; }

Trajectory line(double offset_m, double yaw_rad) {
  Trajectory trajectory;
  trajectory.name = "a line";
  trajectory.orientation = Orientation::yaw;
  for (int k = 0; k <= 10; ++k) trajectory.points.push_back({at(k), Pose::planar(k, offset_m, yaw_rad)});
  return trajectory;
}

std::vector<PoseCovariance> covariances(const Eigen::Vector3d& sigmas) {
  std::vector<PoseCovariance> all;
  for (int k = 1; k < 10; ++k) all.push_back({at(k + 0.5), sigmas.cwiseAbs2().asDiagonal()});
  return all;
}

TEST(Consistency, IsTheErrorInUnitsOfWhatTheFilterSays) {
  const auto result = score_consistency(covariances({1.0, 0.5, 0.1}), line(1.0, 0.2), line(0.0, 0.0), {});
  EXPECT_EQ(result.scored, 9U);
  EXPECT_NEAR(result.nees.mean, 4.0 + 4.0, 1e-9);  // (1 / 0.5)² and (0.2 / 0.1)²
  EXPECT_EQ(result.share_within_95, 0.0) << "8 is beyond the 95 % quantile, 7.81";
}

TEST(Consistency, ComparesSigmaWithTheErrorOfEachAxis) {
  const auto result = score_consistency(covariances({1.0, 0.5, 0.1}), line(1.0, 0.2), line(0.0, 0.0), {});
  EXPECT_EQ(result.sigma_by_rms[0], std::nullopt) << "x has no error";
  EXPECT_NEAR(result.sigma_by_rms[1].value(), 0.5, 1e-12);
  EXPECT_NEAR(result.sigma_by_rms[2].value(), 0.5, 1e-12);
}

TEST(Consistency, TurnsTheCovarianceWithTheAlignment) {
  // The estimate lies in a frame turned by 90°: its x is the reference's y.
  Trajectory estimate = line(0.0, 0.0);
  const Pose turn = Pose::planar(0.0, 0.0, 1.5707963267948966);
  for (auto& point : estimate.points) point.pose = turn.inverse() * point.pose;
  Trajectory reference = line(1.0, 0.0);
  const auto result =
      score_consistency(covariances({0.5, 10.0, 1.0}), estimate, reference, {.T_reference_estimate = turn});
  EXPECT_NEAR(result.nees.mean, 4.0, 1e-9);
  EXPECT_EQ(result.share_within_95, 1.0);
}

TEST(Consistency, ACertainStartIsNotScored) {
  auto some = covariances({1.0, 0.5, 0.1});
  some.front().P.setZero();
  EXPECT_EQ(score_consistency(some, line(1.0, 0.2), line(0.0, 0.0), {}).scored, some.size() - 1);
}

TEST(Consistency, TellsHowItChangesOverTime) {
  Trajectory estimate = line(0.0, 0.0);
  for (std::size_t k = 6; k < estimate.points.size(); ++k) estimate.points[k].pose.p.y() = 1.0;
  const auto result = score_consistency(covariances({1.0, 0.5, 0.1}), estimate, line(0.0, 0.0), {});
  EXPECT_NEAR(result.mean_by_quarter.front(), 0.0, 1e-9);
  EXPECT_NEAR(result.mean_by_quarter.back(), 4.0, 1e-9);
}

TEST(Consistency, HasTwoSidedBounds) {
  // χ² with 3 degrees of freedom: 0.2158 and 9.3484 (tables). The error is 1 m throughout; σ makes it 4, 0.04 or 25.
  auto some = covariances({1.0, 0.5, 0.1});
  some[1].P(1, 1) = 25.0;
  some[2].P(1, 1) = 25.0;
  some[3].P(1, 1) = 0.04;
  const auto result = score_consistency(some, line(1.0, 0.0), line(0.0, 0.0), {});
  EXPECT_NEAR(result.low_95, 0.2158, 1e-4);
  EXPECT_NEAR(result.high_95, 9.3484, 1e-4);
  EXPECT_NEAR(result.share_below, 2.0 / 9.0, 1e-12);
  EXPECT_NEAR(result.share_above, 1.0 / 9.0, 1e-12);
  // χ² with 27 degrees of freedom: 14.573 and 43.195.
  EXPECT_NEAR(result.mean_low_95, 14.573 / 9.0, 1e-3);
  EXPECT_NEAR(result.mean_high_95, 43.195 / 9.0, 1e-3);
}

TEST(Consistency, OfPositionsAloneHasTwoDegreesOfFreedom) {
  Trajectory points = line(0.0, 0.0);
  points.orientation = Orientation::none;
  auto some = covariances({1.0, 0.5, 0.1});
  for (PoseCovariance& one : some) one.P(1, 2) = one.P(2, 1) = 0.04;  // says nothing about positions alone
  const auto result = score_consistency(some, line(1.0, 0.2), points, {});
  EXPECT_EQ(result.dimensions, 2);
  EXPECT_NEAR(result.nees.mean, 4.0, 1e-9);
  EXPECT_EQ(result.share_within_95, 1.0) << "the 95 % quantile is 5.99";
  EXPECT_NEAR(result.low_95, 0.0506, 1e-4);
  EXPECT_NEAR(result.high_95, 7.3778, 1e-4);
}

/// A point 2 m to the left of a robot that looks along y: its y moves with the base's, less 2 m times its yaw.
TEST(Consistency, OfPositionsOfAnotherPointHasTheCovarianceOfThatPoint) {
  const Trajectory estimate = line(0.0, std::numbers::pi / 2.0);
  Trajectory points = line(0.0, 0.0);
  points.orientation = Orientation::none;
  for (auto& point : points.points) point.pose.p.x() += -2.0 + 0.3;
  ConsistencyOptions options{.lever_arm_m = {0.0, 2.0, 0.0}};
  // The point is at (-2, 0) from the base: δy = δy_base − 2 δyaw, δx = δx_base.
  auto some = covariances({0.3, 0.3, 0.5});
  EXPECT_NEAR(score_consistency(some, estimate, points, options).nees.mean, 1.0, 1e-9);
  for (auto& point : points.points) point.pose.p += Eigen::Vector3d(-0.3, 1.0, 0.0);
  EXPECT_NEAR(score_consistency(some, estimate, points, options).nees.mean, 1.0 / (0.09 + 4.0 * 0.25), 1e-9);
  options.reference_sigma_m = 0.4;
  const Consistency result = score_consistency(some, estimate, points, options);
  EXPECT_NEAR(result.nees.mean, 1.0 / (0.09 + 4.0 * 0.25 + 0.16), 1e-9);
  EXPECT_NEAR(*result.sigma_by_rms[1], std::sqrt(1.25), 1e-9);
}

TEST(Consistency, NeedsTheEstimatesOrientation) {
  Trajectory points = line(0.0, 0.0);
  points.orientation = Orientation::none;
  EXPECT_THROW(score_consistency(covariances({1.0, 1.0, 1.0}), points, line(0.0, 0.0), {}), Error);
}

TEST(Consistency, WithoutCommonTimesIsAnError) {
  Trajectory later = line(0.0, 0.0);
  for (auto& point : later.points) point.stamp += from_seconds(1000.0);
  EXPECT_THROW(score_consistency(covariances({1.0, 1.0, 1.0}), line(0.0, 0.0), later, {}), Error);
}

TEST(Consistency, ReadsWhatTheTumSinkWrites) {
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder / "covariance.csv";
  std::ofstream(file) << "t_s,xx,xy,xyaw,yy,yyaw,yawyaw\n1.500000000,1,2,3,4,5,6\n";
  const auto read = read_covariances(file);
  ASSERT_EQ(read.size(), 1U);
  EXPECT_EQ(read[0].stamp, at(1.5));
  Eigen::Matrix3d expected;
  expected << 1, 2, 3, 2, 4, 5, 3, 5, 6;
  EXPECT_EQ(read[0].P, expected);
}

class SpatialCovarianceFile : public ::testing::Test {
 protected:
  /// Variances of x, y, yaw, z, rx, ry in this order, with a covariance of x and z.
  std::vector<PoseCovariance> read() const {
    const test::TemporaryFolder folder;
    const std::filesystem::path file = folder.path() / "covariance.csv";
    std::ofstream(file)
        << "t_s,xx,xy,xyaw,yy,yyaw,yawyaw,xz,yz,yawz,zz,xrx,yrx,yawrx,zrx,rxrx,xry,yry,yawry,zry,rxry,ryry\n"
           "1.5,1,0,0,4,0,0.01,0.5,0,0,1,0,0,0,0,0.04,0,0,0,0,0,0.04\n";
    return read_covariances(file);
  }
  static Trajectory at_height(double z, double roll) {
    Trajectory trajectory = line(0.0, 0.0);
    trajectory.orientation = Orientation::full;
    for (auto& point : trajectory.points) {
      point.pose.p.z() = z;
      point.pose.q = so3::from_rpy(roll, 0.0, 0.0);
    }
    return trajectory;
  }
};

TEST_F(SpatialCovarianceFile, HoldsAllSix) {
  const std::vector<PoseCovariance> covariances = read();
  ASSERT_TRUE(covariances.front().P_spatial);
  const SpatialMatrix& P = *covariances.front().P_spatial;
  EXPECT_EQ(P.diagonal(), (SpatialVector() << 1.0, 4.0, 1.0, 0.04, 0.04, 0.01).finished());
  EXPECT_EQ(P(0, 2), 0.5);
  EXPECT_EQ(P(2, 0), 0.5);
}

TEST_F(SpatialCovarianceFile, ScoresHeightAndTilt) {
  const auto result = score_spatial_consistency(read(), at_height(1.0, 0.2), at_height(0.0, 0.0), {});
  ASSERT_TRUE(result);
  EXPECT_EQ(result->dimensions, 6);
  EXPECT_NEAR(result->nees.mean, 1.0 / 0.75 + 1.0, 1e-6);  // z given x: its variance is 1 − 0.5²; and (0.2 / 0.2)²
}

TEST_F(SpatialCovarianceFile, WithoutAWholeOrientationThereIsNothingToScore) {
  EXPECT_FALSE(score_spatial_consistency(read(), at_height(1.0, 0.2), line(0.0, 0.0), {}));
}

}  // namespace
}  // namespace waymark::evaluation
