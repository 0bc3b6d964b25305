// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/cdr/to_ros.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

namespace waymark::ros {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

geometry_msgs::Vector3 vector(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

double or_zero(double value) { return std::isfinite(value) ? value : 0.0; }

}  // namespace

builtin_interfaces::Time to_ros_time(Time time) {
  constexpr std::int64_t kLast = std::int64_t{std::numeric_limits<std::uint32_t>::max()} * kSecond + kSecond - 1;
  const std::int64_t count = std::clamp<std::int64_t>(time.time_since_epoch().count(), 0, kLast);
  return {static_cast<std::int32_t>(static_cast<std::uint32_t>(count / kSecond)),
          static_cast<std::uint32_t>(count % kSecond)};
}

std_msgs::Header to_ros_header(Time stamp, std::string_view frame) { return {to_ros_time(stamp), std::string(frame)}; }

sensor_msgs::Imu to_ros(const ImuSample& sample, std_msgs::Header header) {
  sensor_msgs::Imu message;
  message.header = std::move(header);
  if (sample.q_enu_sensor.coeffs().allFinite()) {
    const auto& q = sample.q_enu_sensor;
    message.orientation = {q.x(), q.y(), q.z(), q.w()};
  } else {
    message.orientation = {0.0, 0.0, 0.0, 1.0};
    message.orientation_covariance[0] = -1.0;
  }
  if (sample.w_sensor.allFinite()) {
    message.angular_velocity = vector(sample.w_sensor);
  } else {
    message.angular_velocity_covariance[0] = -1.0;
  }
  if (sample.f_sensor.allFinite()) {
    message.linear_acceleration = vector(sample.f_sensor);
  } else {
    message.linear_acceleration_covariance[0] = -1.0;
  }
  return message;
}

sensor_msgs::MagneticField to_ros(const MagneticField& field, std_msgs::Header header) {
  sensor_msgs::MagneticField message;
  message.header = std::move(header);
  message.magnetic_field = vector(field.m_sensor);
  return message;
}

sensor_msgs::NavSatFix to_ros(const GnssFix& fix, std_msgs::Header header) {
  constexpr std::uint8_t kDiagonalKnown = 2;
  sensor_msgs::NavSatFix message;
  message.header = std::move(header);
  switch (fix.type) {
    case GnssFix::Type::none:
      message.status.status = -1;
      break;
    case GnssFix::Type::differential:
    case GnssFix::Type::rtk_float:
    case GnssFix::Type::rtk_fixed:
      message.status.status = 2;
      break;
    default:
      message.status.status = 0;
  }
  message.status.service = 1;
  message.latitude = fix.latitude_deg;
  message.longitude = fix.longitude_deg;
  message.altitude = fix.height_m;
  if (std::isfinite(fix.sigma_horizontal_m)) {
    const double horizontal = fix.sigma_horizontal_m * fix.sigma_horizontal_m;
    message.position_covariance[0] = message.position_covariance[4] = horizontal;
    message.position_covariance[8] = or_zero(fix.sigma_vertical_m * fix.sigma_vertical_m);
    message.position_covariance_type = kDiagonalKnown;
  }
  return message;
}

sensor_msgs::LaserScan to_ros(const LaserScan& scan, std_msgs::Header header, float range_min_m, float range_max_m) {
  const auto steps = static_cast<double>(std::max<std::size_t>(scan.ranges_m.size(), 1) - 1);
  sensor_msgs::LaserScan message;
  message.header = std::move(header);
  message.angle_min = static_cast<float>(scan.start_rad);
  message.angle_max = static_cast<float>(scan.start_rad + steps * scan.step_rad);
  message.angle_increment = static_cast<float>(scan.step_rad);
  message.time_increment = static_cast<float>(scan.beam_interval_s);
  message.scan_time = static_cast<float>(scan.beam_interval_s * (steps + 1.0));
  message.range_min = range_min_m;
  message.range_max = range_max_m;
  message.ranges = scan.ranges_m;
  message.intensities = scan.intensities;
  return message;
}

sensor_msgs::PointCloud2 to_ros(const PointCloud& cloud, std_msgs::Header header) {
  constexpr std::uint8_t kUint32 = 6;
  constexpr std::uint8_t kFloat32 = 7;
  sensor_msgs::PointCloud2 message;
  message.header = std::move(header);
  const auto add_field = [&](std::string_view name, std::uint8_t type) {
    message.fields.push_back({std::string(name), message.point_step, type, 1});
    message.point_step += sizeof(float);
  };
  for (const std::string_view name : {"x", "y", "z"}) add_field(name, kFloat32);
  if (!cloud.intensities.empty()) add_field("intensity", kFloat32);
  if (!cloud.offsets_s.empty()) add_field("t", kUint32);
  message.height = 1;
  message.width = static_cast<std::uint32_t>(cloud.points_m.size());
  message.row_step = message.point_step * message.width;
  message.is_dense = true;
  message.data.resize(message.row_step);
  std::uint8_t* out = message.data.data();
  const auto put = [&](const void* value) {
    std::memcpy(out, value, sizeof(float));
    out += sizeof(float);
  };
  for (std::size_t i = 0; i < cloud.points_m.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) put(&cloud.points_m[i][axis]);
    if (!cloud.intensities.empty()) put(&cloud.intensities[i]);
    if (cloud.offsets_s.empty()) continue;
    const double offset_ns = std::clamp(1e9 * static_cast<double>(cloud.offsets_s[i]), 0.0, 4294967295.0);
    const auto offset = static_cast<std::uint32_t>(std::llround(offset_ns));
    put(&offset);
  }
  return message;
}

sensor_msgs::Image to_ros(const Image& image, std_msgs::Header header) {
  const bool colour = image.encoding == Image::Encoding::bgr8;
  sensor_msgs::Image message;
  message.header = std::move(header);
  message.height = static_cast<std::uint32_t>(image.height);
  message.width = static_cast<std::uint32_t>(image.width);
  message.encoding = colour ? "bgr8" : "mono8";
  message.step = message.width * (colour ? 3 : 1);
  message.data = image.data;
  return message;
}

sensor_msgs::CompressedImage to_ros_compressed(const Image& image, std_msgs::Header header) {
  constexpr std::uint8_t kFirstOfPng = 0x89;
  const bool png = !image.data.empty() && image.data.front() == kFirstOfPng;
  return {std::move(header), png ? "png" : "jpeg", image.data};
}

geometry_msgs::TwistStamped to_ros(const BodyTwist& twist, std_msgs::Header header) {
  return {std::move(header), {{twist.v_x_mps, twist.v_y_mps, 0.0}, {0.0, 0.0, twist.w_z_radps}}};
}

sensor_msgs::JointState to_ros(const WheelSpeeds& speeds, std_msgs::Header header, const WheelJoints& joints) {
  sensor_msgs::JointState message;
  message.header = std::move(header);
  const auto add = [&](const std::vector<std::string>& names, double speed_mps) {
    message.name.insert(message.name.end(), names.begin(), names.end());
    message.velocity.insert(message.velocity.end(), names.size(), speed_mps / joints.radius_m);
  };
  add(joints.left, speeds.left_mps);
  add(joints.right, speeds.right_mps);
  return message;
}

}  // namespace waymark::ros
