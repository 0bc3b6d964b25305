// SPDX-License-Identifier: Apache-2.0
// Every message, each filled with values of its own.
#pragma once

#include <cstdint>
#include <string>
#include <tuple>
#include <type_traits>

#include "plugins/shared/cdr/message.hpp"
#include "plugins/shared/cdr/ros/diagnostic_msgs.hpp"
#include "plugins/shared/cdr/ros/geometry_msgs.hpp"
#include "plugins/shared/cdr/ros/nav_msgs.hpp"
#include "plugins/shared/cdr/ros/sensor_msgs.hpp"
#include "plugins/shared/cdr/ros/std_msgs.hpp"
#include "plugins/shared/cdr/ros/visualization_msgs.hpp"

namespace waymark::ros_test {

using AllMessages = std::tuple<
    ros::builtin_interfaces::Time, ros::builtin_interfaces::Duration, ros::std_msgs::Header, ros::std_msgs::ColorRGBA,
    ros::rosgraph_msgs::Clock, ros::geometry_msgs::Vector3, ros::geometry_msgs::Point, ros::geometry_msgs::Point32,
    ros::geometry_msgs::Quaternion, ros::geometry_msgs::Pose, ros::geometry_msgs::PoseStamped,
    ros::geometry_msgs::PoseWithCovariance, ros::geometry_msgs::PoseWithCovarianceStamped, ros::geometry_msgs::Twist,
    ros::geometry_msgs::TwistStamped, ros::geometry_msgs::TwistWithCovariance,
    ros::geometry_msgs::TwistWithCovarianceStamped, ros::geometry_msgs::Transform, ros::geometry_msgs::TransformStamped,
    ros::tf2_msgs::TFMessage, ros::sensor_msgs::Imu, ros::sensor_msgs::MagneticField, ros::sensor_msgs::NavSatStatus,
    ros::sensor_msgs::NavSatFix, ros::sensor_msgs::LaserScan, ros::sensor_msgs::PointField,
    ros::sensor_msgs::PointCloud2, ros::sensor_msgs::Image, ros::sensor_msgs::CompressedImage,
    ros::sensor_msgs::RegionOfInterest, ros::sensor_msgs::CameraInfo, ros::sensor_msgs::JointState,
    ros::nav_msgs::Odometry, ros::nav_msgs::Path, ros::nav_msgs::MapMetaData, ros::nav_msgs::OccupancyGrid,
    ros::map_msgs::OccupancyGridUpdate, ros::octomap_msgs::Octomap, ros::visualization_msgs::UVCoordinate,
    ros::visualization_msgs::MeshFile, ros::visualization_msgs::Marker, ros::visualization_msgs::MarkerArray,
    ros::diagnostic_msgs::KeyValue, ros::diagnostic_msgs::DiagnosticStatus, ros::diagnostic_msgs::DiagnosticArray>;

/// Fills a message; lists get one, two or three elements, texts lengths of all remainders by 8.
class Filler {
 public:
  template <class T>
  void fill(T& value) {
    ++count_;
    if constexpr (std::is_same_v<T, bool>) {
      value = count_ % 2 == 0;
    } else if constexpr (std::is_same_v<T, std::byte>) {
      value = static_cast<std::byte>(count_);
    } else if constexpr (std::is_floating_point_v<T>) {
      value = static_cast<T>(count_) + static_cast<T>(0.25);
    } else if constexpr (std::is_integral_v<T>) {
      value = static_cast<T>(count_ * 3);
    } else if constexpr (std::is_same_v<T, std::string>) {
      value = std::string(count_ % 8, 'x');
    } else if constexpr (ros::detail::IsArray<T>::value || ros::detail::IsVector<T>::value) {
      if constexpr (ros::detail::IsVector<T>::value) value.resize(1 + count_ % 3);
      for (auto& element : value) fill(element);
    } else {
      T::list_fields(value, [this](std::string_view, auto& field) { this->fill(field); });
    }
  }

 private:
  std::uint64_t count_ = 0;
};

/// Calls `check` with each message, filled.
template <class Check>
void for_each_message(Check check) {
  std::apply([&](auto... message) { ((Filler().fill(message), check(message)), ...); }, AllMessages());
}

}  // namespace waymark::ros_test
