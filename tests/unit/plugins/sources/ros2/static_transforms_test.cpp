// SPDX-License-Identifier: Apache-2.0
#include "static_transforms.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "initial_pose.hpp"
#include "plugins/shared/cdr/wire_reader.hpp"

namespace waymark::ros2 {
namespace {

ros::geometry_msgs::TransformStamped transform(const std::string& parent, const std::string& child, double x,
                                               double yaw = 0.0) {
  ros::geometry_msgs::TransformStamped result;
  result.header.frame_id = parent;
  result.child_frame_id = child;
  result.transform.translation.x = x;
  result.transform.rotation = {0.0, 0.0, std::sin(0.5 * yaw), std::cos(0.5 * yaw)};
  return result;
}

TEST(StaticTransforms, AreFollowedThroughChainsAndAcrossTheRoot) {
  StaticTransforms transforms;
  transforms.add(
      {{transform("base_footprint", "base_link", 0.0), transform("base_link", "mast", 1.0, 0.5 * std::numbers::pi)}});
  transforms.add({{transform("mast", "laser", 2.0), transform("base_footprint", "gps", 5.0)}});
  const auto laser = transforms.find("base_link", "laser");
  ASSERT_TRUE(laser);
  EXPECT_NEAR(laser->p.x(), 1.0, 1e-12);
  EXPECT_NEAR(laser->p.y(), 2.0, 1e-12);
  EXPECT_NEAR(laser->yaw(), 0.5 * std::numbers::pi, 1e-12);
  const auto gps = transforms.find("base_link", "/gps");
  ASSERT_TRUE(gps);
  EXPECT_NEAR(gps->p.x(), 5.0, 1e-12);
  EXPECT_NEAR(transforms.find("laser", "base_link")->p.x(), -2.0, 1e-12);
}

TEST(StaticTransforms, WhatIsNotConnectedIsNotFound) {
  StaticTransforms transforms;
  transforms.add({{transform("base_link", "laser", 1.0), transform("world", "camera", 1.0)}});
  EXPECT_FALSE(transforms.find("base_link", "camera"));
  EXPECT_EQ(transforms.list(), "camera (in world), laser (in base_link)");
}

TEST(StaticTransforms, CirclesEnd) {
  StaticTransforms transforms;
  transforms.add({{transform("a", "b", 1.0), transform("b", "a", 1.0)}});
  EXPECT_FALSE(transforms.find("base_link", "a"));
}

TEST(StaticTransforms, WhatIsNoTransformIsRefusedAndNothingOfItsMessageIsKept) {
  StaticTransforms transforms;
  auto broken = transform("base_link", "camera", 1.0);
  broken.transform.rotation.w = std::nan("");
  EXPECT_THROW(transforms.add({{transform("base_link", "laser", 1.0), broken}}), ros::Unusable);
  EXPECT_FALSE(transforms.find("base_link", "laser"));
  EXPECT_THROW(transforms.add({{transform("base_link", "", 1.0)}}), ros::Unusable);
}

TEST(InitialPose, BecomesACommandWithTheSigmasOfItsCovariance) {
  ros::geometry_msgs::PoseWithCovarianceStamped message;
  message.header.frame_id = "map";
  message.pose.pose.position = {1.5, -2.0, 0.0};
  message.pose.pose.orientation = {0.0, 0.0, 1.0, 0.0};
  EXPECT_EQ(set_pose_command(message, "map"), "set-pose 1.5 -2 180");
  message.pose.covariance[0] = message.pose.covariance[7] = 0.25;
  message.pose.covariance[35] = 0.25;
  EXPECT_EQ(set_pose_command(message, "map"), "set-pose 1.5 -2 180 0.5 28.64788975654116");
}

TEST(InitialPose, IsRefusedInAnotherFrameAndIfItIsNoPose) {
  ros::geometry_msgs::PoseWithCovarianceStamped message;
  message.header.frame_id = "odom";
  EXPECT_THROW(set_pose_command(message, "map"), ros::Unusable);
  message.header.frame_id = "/map";
  message.pose.pose.position.x = std::nan("");
  EXPECT_THROW(set_pose_command(message, "map"), ros::Unusable);
  message.pose.pose.position.x = 0.0;
  message.pose.pose.orientation = {0.0, 0.0, 0.0, 0.0};
  EXPECT_THROW(set_pose_command(message, "map"), ros::Unusable);
}

}  // namespace
}  // namespace waymark::ros2
