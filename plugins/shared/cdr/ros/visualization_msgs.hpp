// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "plugins/shared/cdr/ros/sensor_msgs.hpp"

/// Messages of ROS; their definitions are in the packages of these names.
namespace waymark::ros::visualization_msgs {

struct UVCoordinate {
  static constexpr std::string_view kType = "visualization_msgs/msg/UVCoordinate";
  float u = 0.0f;
  float v = 0.0f;

  bool operator==(const UVCoordinate&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("u", self.u);
    field("v", self.v);
  }
};

struct MeshFile {
  static constexpr std::string_view kType = "visualization_msgs/msg/MeshFile";
  std::string filename;
  std::vector<std::uint8_t> data;

  bool operator==(const MeshFile&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("filename", self.filename);
    field("data", self.data);
  }
};

/// As of ROS 2 Humble and later.
struct Marker {
  static constexpr std::string_view kType = "visualization_msgs/msg/Marker";
  std_msgs::Header header;
  std::string ns;
  std::int32_t id = 0;
  std::int32_t type = 0;
  std::int32_t action = 0;
  geometry_msgs::Pose pose;
  geometry_msgs::Vector3 scale;
  std_msgs::ColorRGBA color;
  builtin_interfaces::Duration lifetime;
  bool frame_locked = false;
  std::vector<geometry_msgs::Point> points;
  std::vector<std_msgs::ColorRGBA> colors;
  std::string texture_resource;
  sensor_msgs::CompressedImage texture;
  std::vector<UVCoordinate> uv_coordinates;
  std::string text;
  std::string mesh_resource;
  MeshFile mesh_file;
  bool mesh_use_embedded_materials = false;

  bool operator==(const Marker&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("header", self.header);
    field("ns", self.ns);
    field("id", self.id);
    field("type", self.type);
    field("action", self.action);
    field("pose", self.pose);
    field("scale", self.scale);
    field("color", self.color);
    field("lifetime", self.lifetime);
    field("frame_locked", self.frame_locked);
    field("points", self.points);
    field("colors", self.colors);
    field("texture_resource", self.texture_resource);
    field("texture", self.texture);
    field("uv_coordinates", self.uv_coordinates);
    field("text", self.text);
    field("mesh_resource", self.mesh_resource);
    field("mesh_file", self.mesh_file);
    field("mesh_use_embedded_materials", self.mesh_use_embedded_materials);
  }
};

struct MarkerArray {
  static constexpr std::string_view kType = "visualization_msgs/msg/MarkerArray";
  std::vector<Marker> markers;

  bool operator==(const MarkerArray&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("markers", self.markers);
  }
};

}  // namespace waymark::ros::visualization_msgs
