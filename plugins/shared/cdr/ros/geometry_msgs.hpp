// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "plugins/shared/cdr/ros/std_msgs.hpp"

/// Messages of ROS; their definitions are in the packages of these names.
namespace waymark::ros::geometry_msgs {

struct Vector3 {
  static constexpr std::string_view kType = "geometry_msgs/msg/Vector3";
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;

  bool operator==(const Vector3&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("x", self.x);
    field("y", self.y);
    field("z", self.z);
  }
};

struct Point {
  static constexpr std::string_view kType = "geometry_msgs/msg/Point";
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;

  bool operator==(const Point&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("x", self.x);
    field("y", self.y);
    field("z", self.z);
  }
};

struct Point32 {
  static constexpr std::string_view kType = "geometry_msgs/msg/Point32";
  float x = 0.0f;
  float y = 0.0f;
  float z = 0.0f;

  bool operator==(const Point32&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("x", self.x);
    field("y", self.y);
    field("z", self.z);
  }
};

struct Quaternion {
  static constexpr std::string_view kType = "geometry_msgs/msg/Quaternion";
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
  double w = 1.0;

  bool operator==(const Quaternion&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("x", self.x);
    field("y", self.y);
    field("z", self.z);
    field("w", self.w);
  }
};

struct Pose {
  static constexpr std::string_view kType = "geometry_msgs/msg/Pose";
  Point position;
  Quaternion orientation;

  bool operator==(const Pose&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("position", self.position);
    field("orientation", self.orientation);
  }
};

struct PoseStamped {
  static constexpr std::string_view kType = "geometry_msgs/msg/PoseStamped";
  std_msgs::Header header;
  Pose pose;

  bool operator==(const PoseStamped&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("header", self.header);
    field("pose", self.pose);
  }
};

/// Covariance of x, y, z and rotations about x, y, z; row by row.
struct PoseWithCovariance {
  static constexpr std::string_view kType = "geometry_msgs/msg/PoseWithCovariance";
  Pose pose;
  std::array<double, 36> covariance{};

  bool operator==(const PoseWithCovariance&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("pose", self.pose);
    field("covariance", self.covariance);
  }
};

struct PoseWithCovarianceStamped {
  static constexpr std::string_view kType = "geometry_msgs/msg/PoseWithCovarianceStamped";
  std_msgs::Header header;
  PoseWithCovariance pose;

  bool operator==(const PoseWithCovarianceStamped&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("header", self.header);
    field("pose", self.pose);
  }
};

struct Twist {
  static constexpr std::string_view kType = "geometry_msgs/msg/Twist";
  Vector3 linear;
  Vector3 angular;

  bool operator==(const Twist&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("linear", self.linear);
    field("angular", self.angular);
  }
};

struct TwistStamped {
  static constexpr std::string_view kType = "geometry_msgs/msg/TwistStamped";
  std_msgs::Header header;
  Twist twist;

  bool operator==(const TwistStamped&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("header", self.header);
    field("twist", self.twist);
  }
};

/// Covariance as of PoseWithCovariance.
struct TwistWithCovariance {
  static constexpr std::string_view kType = "geometry_msgs/msg/TwistWithCovariance";
  Twist twist;
  std::array<double, 36> covariance{};

  bool operator==(const TwistWithCovariance&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("twist", self.twist);
    field("covariance", self.covariance);
  }
};

struct TwistWithCovarianceStamped {
  static constexpr std::string_view kType = "geometry_msgs/msg/TwistWithCovarianceStamped";
  std_msgs::Header header;
  TwistWithCovariance twist;

  bool operator==(const TwistWithCovarianceStamped&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("header", self.header);
    field("twist", self.twist);
  }
};

struct Transform {
  static constexpr std::string_view kType = "geometry_msgs/msg/Transform";
  Vector3 translation;
  Quaternion rotation;

  bool operator==(const Transform&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("translation", self.translation);
    field("rotation", self.rotation);
  }
};

struct TransformStamped {
  static constexpr std::string_view kType = "geometry_msgs/msg/TransformStamped";
  std_msgs::Header header;
  std::string child_frame_id;
  Transform transform;

  bool operator==(const TransformStamped&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("header", self.header);
    field("child_frame_id", self.child_frame_id);
    field("transform", self.transform);
  }
};

}  // namespace waymark::ros::geometry_msgs

namespace waymark::ros::tf2_msgs {

struct TFMessage {
  static constexpr std::string_view kType = "tf2_msgs/msg/TFMessage";
  std::vector<geometry_msgs::TransformStamped> transforms;

  bool operator==(const TFMessage&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("transforms", self.transforms);
  }
};

}  // namespace waymark::ros::tf2_msgs
