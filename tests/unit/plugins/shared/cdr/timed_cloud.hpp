// SPDX-License-Identifier: Apache-2.0
// Clouds of ROS with times of their points, as drivers of scanners write them.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "plugins/shared/cdr/ros/sensor_msgs.hpp"

namespace waymark::ros_test {

/// Types of a field of a point.
enum PointType : std::uint8_t { kUint16 = 4, kInt32 = 5, kUint32 = 6, kFloat32 = 7, kFloat64 = 8 };

/// Point i at (i, 2 i, 3 i) with the intensity 10 i, and its time in a field of this name and type.
inline ros::sensor_msgs::PointCloud2 timed_cloud(ros::std_msgs::Header header, const std::string& name, PointType type,
                                                 const std::vector<double>& times) {
  const std::uint32_t bytes = type == kFloat64 ? 8 : type == kUint16 ? 2 : 4;
  ros::sensor_msgs::PointCloud2 message;
  message.header = std::move(header);
  message.fields = {{"x", 0, kFloat32, 1},
                    {"y", 4, kFloat32, 1},
                    {"z", 8, kFloat32, 1},
                    {"intensity", 12, kFloat32, 1},
                    {name, 16, type, 1}};
  message.point_step = 16 + bytes;
  message.height = 1;
  message.width = static_cast<std::uint32_t>(times.size());
  message.row_step = message.point_step * message.width;
  message.is_dense = true;
  message.data.resize(message.row_step);
  std::uint8_t* at = message.data.data();
  const auto put = [&at]<class T>(T value) {
    std::memcpy(at, &value, sizeof value);
    at += sizeof value;
  };
  for (std::size_t i = 0; i < times.size(); ++i) {
    const auto k = static_cast<float>(i);
    for (const float value : {k, 2.0f * k, 3.0f * k, 10.0f * k}) put(value);
    if (type == kUint16) put(static_cast<std::uint16_t>(times[i]));
    if (type == kInt32) put(static_cast<std::int32_t>(times[i]));
    if (type == kUint32) put(static_cast<std::uint32_t>(times[i]));
    if (type == kFloat32) put(static_cast<float>(times[i]));
    if (type == kFloat64) put(times[i]);
  }
  return message;
}

}  // namespace waymark::ros_test
