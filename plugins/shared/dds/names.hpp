// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

/// How ROS 2 names its topics and types in DDS (ROS 2 design, "Topic and Service name mapping to DDS").
namespace waymark::dds {

/// "rt/imu" of "/imu" or "imu". Throws std::invalid_argument, with what was expected, for what is no name of a topic.
std::string topic_name(std::string_view ros_topic);

/// "sensor_msgs::msg::dds_::Imu_" of "sensor_msgs/msg/Imu". Throws std::invalid_argument for what is no type.
std::string type_name(std::string_view ros_type);

/// "sensor_msgs/msg/Imu" of "sensor_msgs::msg::dds_::Imu_"; what is not of ROS stays as it is.
std::string ros_type(std::string_view dds_type);

}  // namespace waymark::dds
