// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>
#include <vector>

#include "plugins/shared/cdr/conversions.hpp"

/// Payloads as messages of ROS, the inverse of conversions.hpp: what is unknown is written as the message has it.
namespace waymark::ros {

/// Times before 1970 or beyond 2106 cannot be written: they become the nearest one that can.
builtin_interfaces::Time to_ros_time(Time time);
std_msgs::Header to_ros_header(Time stamp, std::string_view frame);

sensor_msgs::Imu to_ros(const ImuSample& sample, std_msgs::Header header);
sensor_msgs::MagneticField to_ros(const MagneticField& field, std_msgs::Header header);
/// Of a fix with latitude and longitude; without them both are NaN.
sensor_msgs::NavSatFix to_ros(const GnssFix& fix, std_msgs::Header header);
/// Angles and times become float32.
sensor_msgs::LaserScan to_ros(const LaserScan& scan, std_msgs::Header header, float range_min_m, float range_max_m);
/// x, y, z, and `intensity` and `t` (uint32, nanoseconds) if there are any.
sensor_msgs::PointCloud2 to_ros(const PointCloud& cloud, std_msgs::Header header);
/// Of an image as pixels.
sensor_msgs::Image to_ros(const Image& image, std_msgs::Header header);
/// Of an image as a file; the format (`jpeg`, `png`) is that of its first byte.
sensor_msgs::CompressedImage to_ros_compressed(const Image& image, std_msgs::Header header);
geometry_msgs::TwistStamped to_ros(const BodyTwist& twist, std_msgs::Header header);
/// With the same speed for all joints of one side.
sensor_msgs::JointState to_ros(const WheelSpeeds& speeds, std_msgs::Header header, const WheelJoints& joints);

}  // namespace waymark::ros
