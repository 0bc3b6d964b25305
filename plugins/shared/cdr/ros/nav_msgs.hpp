// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "plugins/shared/cdr/ros/geometry_msgs.hpp"

/// Messages of ROS; their definitions are in the packages of these names.
namespace waymark::ros::nav_msgs {

/// Pose in the frame of the header, twist in the child frame.
struct Odometry {
  static constexpr std::string_view kType = "nav_msgs/msg/Odometry";
  std_msgs::Header header;
  std::string child_frame_id;
  geometry_msgs::PoseWithCovariance pose;
  geometry_msgs::TwistWithCovariance twist;

  bool operator==(const Odometry&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("header", self.header);
    field("child_frame_id", self.child_frame_id);
    field("pose", self.pose);
    field("twist", self.twist);
  }
};

struct Path {
  static constexpr std::string_view kType = "nav_msgs/msg/Path";
  std_msgs::Header header;
  std::vector<geometry_msgs::PoseStamped> poses;

  bool operator==(const Path&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("header", self.header);
    field("poses", self.poses);
  }
};

struct MapMetaData {
  static constexpr std::string_view kType = "nav_msgs/msg/MapMetaData";
  builtin_interfaces::Time map_load_time;
  float resolution = 0.0f;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  geometry_msgs::Pose origin;

  bool operator==(const MapMetaData&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("map_load_time", self.map_load_time);
    field("resolution", self.resolution);
    field("width", self.width);
    field("height", self.height);
    field("origin", self.origin);
  }
};

/// Percent occupied, −1: unknown; rows from the bottom.
struct OccupancyGrid {
  static constexpr std::string_view kType = "nav_msgs/msg/OccupancyGrid";
  std_msgs::Header header;
  MapMetaData info;
  std::vector<std::int8_t> data;

  bool operator==(const OccupancyGrid&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("header", self.header);
    field("info", self.info);
    field("data", self.data);
  }
};

}  // namespace waymark::ros::nav_msgs

namespace waymark::ros::map_msgs {

struct OccupancyGridUpdate {
  static constexpr std::string_view kType = "map_msgs/msg/OccupancyGridUpdate";
  std_msgs::Header header;
  std::int32_t x = 0;
  std::int32_t y = 0;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<std::int8_t> data;

  bool operator==(const OccupancyGridUpdate&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("header", self.header);
    field("x", self.x);
    field("y", self.y);
    field("width", self.width);
    field("height", self.height);
    field("data", self.data);
  }
};

}  // namespace waymark::ros::map_msgs

namespace waymark::ros::octomap_msgs {

/// An octree as liboctomap writes it, without the file's header.
struct Octomap {
  static constexpr std::string_view kType = "octomap_msgs/msg/Octomap";
  std_msgs::Header header;
  bool binary = false;
  std::string id;
  double resolution = 0.0;
  std::vector<std::int8_t> data;

  bool operator==(const Octomap&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("header", self.header);
    field("binary", self.binary);
    field("id", self.id);
    field("resolution", self.resolution);
    field("data", self.data);
  }
};

}  // namespace waymark::ros::octomap_msgs
