// SPDX-License-Identifier: Apache-2.0
#include "pose_messages.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "smooth_odometry.hpp"
#include "unit/plugins/sinks/fake_snapshot.hpp"

namespace waymark::ros2_publisher {
namespace {

const Frames kFrames{"map", "odom", "base_link"};

Time at(double seconds) { return Time{from_seconds(seconds)}; }

Pose pose_of(const ros::geometry_msgs::TransformStamped& transform) {
  const auto& [p, q] = transform.transform;
  return {Eigen::Quaterniond(q.w, q.x, q.y, q.z), {p.x, p.y, p.z}};
}

TEST(SmoothOdometry, IntegratesAConstantTwistExactly) {
  SmoothOdometry odometry;
  for (int k = 0; k <= 10; ++k)
    odometry.step(at(0.1 * k), {std::numbers::pi, 0.0, 0.0}, {0.0, 0.0, std::numbers::pi}, 0.0, 0.0);
  // A half circle of 1 m radius.
  EXPECT_NEAR(odometry.T_odom_base().p.x(), 0.0, 1e-9);
  EXPECT_NEAR(odometry.T_odom_base().p.y(), 2.0, 1e-9);
  EXPECT_NEAR(std::abs(odometry.T_odom_base().yaw()), std::numbers::pi, 1e-9);
}

TEST(SmoothOdometry, ItsSigmaGrowsWithTheWay) {
  SmoothOdometry odometry;
  for (int k = 0; k <= 100; ++k) odometry.step(at(0.1 * k), {1.0, 0.0, 0.0}, Eigen::Vector3d::Zero(), 0.02, 0.001);
  EXPECT_NEAR(odometry.rotation_sigma_rad(), 0.01, 1e-9);
  EXPECT_NEAR(odometry.position_sigma_m(), 0.2 + 0.05, 0.001);
}

TEST(SmoothOdometry, DoesNotDriveOnThroughAGap) {
  SmoothOdometry odometry;
  odometry.step(at(0.0), {1.0, 0.0, 0.0}, Eigen::Vector3d::Zero(), 0.0, 0.0);
  odometry.step(at(100.0), {1.0, 0.0, 0.0}, Eigen::Vector3d::Zero(), 0.0, 0.0);
  EXPECT_NEAR(odometry.T_odom_base().p.x(), 1.0, 1e-9);
}

class PoseMessages : public ::testing::Test {
 protected:
  PoseMessages() {
    snapshot_.at(10.0, Pose::planar(3.0, 4.0, 0.5)).pose_variance(0.01, 0.04, 0.0025);
    snapshot_.belief_.mean.v_base = {1.0, 0.0, 0.0};
    snapshot_.belief_.mean.w_base = {0.0, 0.0, 0.2};
  }
  const Belief& belief() const { return snapshot_.belief_; }

  test::FakeSnapshot snapshot_;
  StateIndices indices_{snapshot_.layout_};
};

TEST_F(PoseMessages, OdometryInTheMapIsThePoseWithItsCovariance) {
  const auto message = odometry_in_map(belief(), indices_, kFrames);
  EXPECT_EQ(message.header.frame_id, "map");
  EXPECT_EQ(message.child_frame_id, "base_link");
  EXPECT_EQ(message.header.stamp.sec, 10);
  EXPECT_EQ(message.pose.pose.position.y, 4.0);
  EXPECT_NEAR(message.pose.pose.orientation.z, std::sin(0.25), 1e-12);
  EXPECT_EQ(message.pose.covariance[0], 0.01);
  EXPECT_EQ(message.pose.covariance[7], 0.04);
  EXPECT_EQ(message.pose.covariance[35], 0.0025);
  EXPECT_EQ(message.pose.covariance[14], 0.0) << "planar motion knows z";
  EXPECT_EQ(message.twist.twist.linear.x, 1.0);
  EXPECT_EQ(message.twist.twist.angular.z, 0.2);
}

TEST_F(PoseMessages, MapToOdomToBaseIsThePoseInTheMapAlsoAfterItJumps) {
  SmoothOdometry smooth;
  smooth.step(at(9.0), {1.0, 0.0, 0.0}, {0.0, 0.0, 0.2}, 0.0, 0.0);
  smooth.step(at(10.0), {1.0, 0.0, 0.0}, {0.0, 0.0, 0.2}, 0.0, 0.0);
  const auto before = transforms(belief(), kFrames, smooth, Duration::zero());
  snapshot_.belief_.mean.T_map_base = Pose::planar(-7.0, 1.0, 2.0);
  const auto after = transforms(belief(), kFrames, smooth, from_seconds(0.1));
  ASSERT_EQ(after.transforms.size(), 2U);
  EXPECT_EQ(after.transforms[0].header.frame_id, "map");
  EXPECT_EQ(after.transforms[0].child_frame_id, "odom");
  EXPECT_EQ(after.transforms[1].child_frame_id, "base_link");
  const Pose T_map_base = pose_of(after.transforms[0]) * pose_of(after.transforms[1]);
  EXPECT_NEAR(T_map_base.p.x(), -7.0, 1e-9);
  EXPECT_NEAR(T_map_base.yaw(), 2.0, 1e-9);
  EXPECT_EQ(before.transforms[1], after.transforms[1]) << "odom to base is smooth";
  EXPECT_EQ(after.transforms[0].header.stamp.nanosec, 100'000'000U);
  EXPECT_EQ(after.transforms[1].header.stamp.nanosec, 0U);
}

TEST_F(PoseMessages, TheFixLiesAroundTheDatum) {
  snapshot_.belief_.mean.T_map_base = Pose::planar(0.0, 111.2, 0.0);
  const auto message = fix(belief(), indices_, kFrames, {49.0, 8.0, 100.0});
  EXPECT_NEAR(message.latitude, 49.001, 1e-6);
  EXPECT_NEAR(message.longitude, 8.0, 1e-9);
  EXPECT_NEAR(message.altitude, 100.0, 0.01);
  EXPECT_EQ(message.position_covariance[4], 0.04);
}

}  // namespace
}  // namespace waymark::ros2_publisher
