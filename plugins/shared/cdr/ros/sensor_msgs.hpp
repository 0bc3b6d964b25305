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
namespace waymark::ros::sensor_msgs {

/// Covariances of 3 x 3; −1 in front: not measured.
struct Imu {
  static constexpr std::string_view kType = "sensor_msgs/msg/Imu";
  std_msgs::Header header;
  geometry_msgs::Quaternion orientation;
  std::array<double, 9> orientation_covariance{};
  geometry_msgs::Vector3 angular_velocity;
  std::array<double, 9> angular_velocity_covariance{};
  geometry_msgs::Vector3 linear_acceleration;
  std::array<double, 9> linear_acceleration_covariance{};

  bool operator==(const Imu&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("header", self.header);
    field("orientation", self.orientation);
    field("orientation_covariance", self.orientation_covariance);
    field("angular_velocity", self.angular_velocity);
    field("angular_velocity_covariance", self.angular_velocity_covariance);
    field("linear_acceleration", self.linear_acceleration);
    field("linear_acceleration_covariance", self.linear_acceleration_covariance);
  }
};

struct MagneticField {
  static constexpr std::string_view kType = "sensor_msgs/msg/MagneticField";
  std_msgs::Header header;
  geometry_msgs::Vector3 magnetic_field;
  std::array<double, 9> magnetic_field_covariance{};

  bool operator==(const MagneticField&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("header", self.header);
    field("magnetic_field", self.magnetic_field);
    field("magnetic_field_covariance", self.magnetic_field_covariance);
  }
};

/// −1: no fix, 0: fix, 1: satellite-based, 2: ground-based augmentation.
struct NavSatStatus {
  static constexpr std::string_view kType = "sensor_msgs/msg/NavSatStatus";
  std::int8_t status = 0;
  std::uint16_t service = 0;

  bool operator==(const NavSatStatus&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("status", self.status);
    field("service", self.service);
  }
};

/// Covariance of east, north, up. Its type: 0 unknown, 1 approximated, 2 diagonal known, 3 known.
struct NavSatFix {
  static constexpr std::string_view kType = "sensor_msgs/msg/NavSatFix";
  std_msgs::Header header;
  NavSatStatus status;
  double latitude = 0.0;
  double longitude = 0.0;
  double altitude = 0.0;
  std::array<double, 9> position_covariance{};
  std::uint8_t position_covariance_type = 0;

  bool operator==(const NavSatFix&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("header", self.header);
    field("status", self.status);
    field("latitude", self.latitude);
    field("longitude", self.longitude);
    field("altitude", self.altitude);
    field("position_covariance", self.position_covariance);
    field("position_covariance_type", self.position_covariance_type);
  }
};

struct LaserScan {
  static constexpr std::string_view kType = "sensor_msgs/msg/LaserScan";
  std_msgs::Header header;
  float angle_min = 0.0f;
  float angle_max = 0.0f;
  float angle_increment = 0.0f;
  float time_increment = 0.0f;
  float scan_time = 0.0f;
  float range_min = 0.0f;
  float range_max = 0.0f;
  std::vector<float> ranges;
  std::vector<float> intensities;

  bool operator==(const LaserScan&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("header", self.header);
    field("angle_min", self.angle_min);
    field("angle_max", self.angle_max);
    field("angle_increment", self.angle_increment);
    field("time_increment", self.time_increment);
    field("scan_time", self.scan_time);
    field("range_min", self.range_min);
    field("range_max", self.range_max);
    field("ranges", self.ranges);
    field("intensities", self.intensities);
  }
};

/// A number of every point. Types 1 to 8: int8, uint8, int16, uint16, int32, uint32, float32, float64.
struct PointField {
  static constexpr std::string_view kType = "sensor_msgs/msg/PointField";
  std::string name;
  std::uint32_t offset = 0;
  std::uint8_t datatype = 0;
  std::uint32_t count = 0;

  bool operator==(const PointField&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("name", self.name);
    field("offset", self.offset);
    field("datatype", self.datatype);
    field("count", self.count);
  }
};

struct PointCloud2 {
  static constexpr std::string_view kType = "sensor_msgs/msg/PointCloud2";
  std_msgs::Header header;
  std::uint32_t height = 0;
  std::uint32_t width = 0;
  std::vector<PointField> fields;
  bool is_bigendian = false;
  std::uint32_t point_step = 0;
  std::uint32_t row_step = 0;
  std::vector<std::uint8_t> data;
  bool is_dense = false;

  bool operator==(const PointCloud2&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("header", self.header);
    field("height", self.height);
    field("width", self.width);
    field("fields", self.fields);
    field("is_bigendian", self.is_bigendian);
    field("point_step", self.point_step);
    field("row_step", self.row_step);
    field("data", self.data);
    field("is_dense", self.is_dense);
  }
};

struct Image {
  static constexpr std::string_view kType = "sensor_msgs/msg/Image";
  std_msgs::Header header;
  std::uint32_t height = 0;
  std::uint32_t width = 0;
  std::string encoding;
  std::uint8_t is_bigendian = 0;
  std::uint32_t step = 0;
  std::vector<std::uint8_t> data;

  bool operator==(const Image&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("header", self.header);
    field("height", self.height);
    field("width", self.width);
    field("encoding", self.encoding);
    field("is_bigendian", self.is_bigendian);
    field("step", self.step);
    field("data", self.data);
  }
};

struct CompressedImage {
  static constexpr std::string_view kType = "sensor_msgs/msg/CompressedImage";
  std_msgs::Header header;
  std::string format;
  std::vector<std::uint8_t> data;

  bool operator==(const CompressedImage&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("header", self.header);
    field("format", self.format);
    field("data", self.data);
  }
};

struct RegionOfInterest {
  static constexpr std::string_view kType = "sensor_msgs/msg/RegionOfInterest";
  std::uint32_t x_offset = 0;
  std::uint32_t y_offset = 0;
  std::uint32_t height = 0;
  std::uint32_t width = 0;
  bool do_rectify = false;

  bool operator==(const RegionOfInterest&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("x_offset", self.x_offset);
    field("y_offset", self.y_offset);
    field("height", self.height);
    field("width", self.width);
    field("do_rectify", self.do_rectify);
  }
};

struct CameraInfo {
  static constexpr std::string_view kType = "sensor_msgs/msg/CameraInfo";
  std_msgs::Header header;
  std::uint32_t height = 0;
  std::uint32_t width = 0;
  std::string distortion_model;
  std::vector<double> d;
  std::array<double, 9> k{};
  std::array<double, 9> r{};
  std::array<double, 12> p{};
  std::uint32_t binning_x = 0;
  std::uint32_t binning_y = 0;
  RegionOfInterest roi;

  bool operator==(const CameraInfo&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("header", self.header);
    field("height", self.height);
    field("width", self.width);
    field("distortion_model", self.distortion_model);
    field("d", self.d);
    field("k", self.k);
    field("r", self.r);
    field("p", self.p);
    field("binning_x", self.binning_x);
    field("binning_y", self.binning_y);
    field("roi", self.roi);
  }
};

struct JointState {
  static constexpr std::string_view kType = "sensor_msgs/msg/JointState";
  std_msgs::Header header;
  std::vector<std::string> name;
  std::vector<double> position;
  std::vector<double> velocity;
  std::vector<double> effort;

  bool operator==(const JointState&) const = default;

  template <class Self, class Visitor>
  static void list_fields(Self& self, Visitor&& field) {
    field("header", self.header);
    field("name", self.name);
    field("position", self.position);
    field("velocity", self.velocity);
    field("effort", self.effort);
  }
};

}  // namespace waymark::ros::sensor_msgs
