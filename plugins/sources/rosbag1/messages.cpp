// SPDX-License-Identifier: Apache-2.0
#include "messages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "waymark/interface/payloads.hpp"

namespace waymark::rosbag1 {
namespace {

Eigen::Vector3d vector(Wire& wire) {
  const auto x = wire.value<double>();
  const auto y = wire.value<double>();
  const auto z = wire.value<double>();
  return {x, y, z};
}

template <std::size_t N>
std::array<double, N> numbers(Wire& wire) {
  std::array<double, N> values{};
  for (double& value : values) value = wire.value<double>();
  return values;
}

void require_finite(const Eigen::Vector3d& v, std::string_view what) {
  if (!v.allFinite()) throw Unusable(fmt::format("the {} is ({}, {}, {}), not finite", what, v.x(), v.y(), v.z()));
}

/// A covariance whose first number is -1 means that there is no such measurement.
bool is_absent(const std::array<double, 9>& covariance) { return covariance[0] == -1.0; }

/// The σ that a variance stands for; zero, negative or NaN: unknown.
double sigma_of(double variance) {
  return variance > 0.0 && std::isfinite(variance) ? std::sqrt(variance) : std::numeric_limits<double>::quiet_NaN();
}

std::shared_ptr<Payload> imu(Wire& wire) {
  auto sample = std::make_shared<ImuSample>();
  const auto q = numbers<4>(wire);  // x, y, z, w
  const auto q_covariance = numbers<9>(wire);
  const Eigen::Vector3d w = vector(wire);
  const auto w_covariance = numbers<9>(wire);
  const Eigen::Vector3d f = vector(wire);
  const auto f_covariance = numbers<9>(wire);
  if (!is_absent(w_covariance)) {
    require_finite(w, "angular velocity");
    sample->w_sensor = w;
  }
  if (!is_absent(f_covariance)) {
    require_finite(f, "linear acceleration");
    sample->f_sensor = f;
  }
  const Eigen::Quaterniond orientation(q[3], q[0], q[1], q[2]);
  const double norm = orientation.norm();
  if (!is_absent(q_covariance) && norm != 0.0) {
    constexpr double kLoose = 0.01;
    constexpr double kTight = 1e-9;  // what was normalised once stays as it is, bit by bit
    if (!(std::abs(norm - 1.0) < kLoose)) {
      throw Unusable(fmt::format("the orientation ({}, {}, {}, {}) is not a unit quaternion", q[0], q[1], q[2], q[3]));
    }
    sample->q_enu_sensor = std::abs(norm - 1.0) < kTight ? orientation : orientation.normalized();
  } else if (is_absent(w_covariance)) {
    throw Unusable("it has neither an angular velocity nor an orientation");
  }
  return sample;
}

std::shared_ptr<Payload> magnetic_field(Wire& wire) {
  auto field = std::make_shared<MagneticField>();
  field->m_sensor = vector(wire);
  numbers<9>(wire);
  require_finite(field->m_sensor, "magnetic field");
  return field;
}

std::shared_ptr<Payload> nav_sat_fix(Wire& wire) {
  auto fix = std::make_shared<GnssFix>();
  const auto status = wire.value<std::int8_t>();
  wire.value<std::uint16_t>();  // which systems
  const auto position = numbers<3>(wire);
  const auto covariance = numbers<9>(wire);  // east, north, up
  const int covariance_type = wire.value<std::uint8_t>();
  fix->type = status < 0    ? GnssFix::Type::none
              : status == 0 ? GnssFix::Type::single
              : status <= 2 ? GnssFix::Type::differential
                            : GnssFix::Type::unknown;
  const bool known = std::isfinite(position[0]) && std::isfinite(position[1]);
  if (!known && fix->type != GnssFix::Type::none) {
    throw Unusable(fmt::format("a fix of status {} at latitude {}, longitude {}", status, position[0], position[1]));
  }
  if (known) {
    if (std::abs(position[0]) > 90.0) throw Unusable(fmt::format("{} is not a latitude (-90 to 90 deg)", position[0]));
    fix->latitude_deg = position[0];
    fix->longitude_deg = position[1];
    if (std::isfinite(position[2])) fix->height_m = position[2];
  }
  if (covariance_type != 0) {
    fix->sigma_horizontal_m = sigma_of(0.5 * (covariance[0] + covariance[4]));
    fix->sigma_vertical_m = sigma_of(covariance[8]);
  }
  return fix;
}

std::shared_ptr<Payload> body_twist(const Eigen::Vector3d& linear, const Eigen::Vector3d& angular) {
  require_finite(linear, "linear velocity");
  require_finite(angular, "angular velocity");
  auto twist = std::make_shared<BodyTwist>();
  twist->v_x_mps = linear.x();
  twist->v_y_mps = linear.y();
  twist->w_z_radps = angular.z();
  return twist;
}

struct Odometry {
  Eigen::Vector3d position;
  std::array<double, 36> pose_covariance;  // x, y, z, roll, pitch, yaw
  Eigen::Vector3d linear;
  Eigen::Vector3d angular;
};

Odometry odometry(Wire& wire) {
  Odometry message;
  wire.text();  // the child frame
  message.position = vector(wire);
  numbers<4>(wire);
  message.pose_covariance = numbers<36>(wire);
  message.linear = vector(wire);
  message.angular = vector(wire);
  numbers<36>(wire);
  return message;
}

std::shared_ptr<Payload> odometry_twist(Wire& wire) {
  const Odometry message = odometry(wire);
  return body_twist(message.linear, message.angular);
}

std::shared_ptr<Payload> odometry_height(Wire& wire) {
  constexpr std::size_t kVarianceOfZ = 2 * 6 + 2;
  const Odometry message = odometry(wire);
  require_finite(message.position, "position");
  auto height = std::make_shared<Height>();
  height->height_m = message.position.z();
  height->sigma_m = sigma_of(message.pose_covariance[kVarianceOfZ]);
  return height;
}

std::shared_ptr<Payload> twist(Wire& wire) {
  const Eigen::Vector3d linear = vector(wire);
  return body_twist(linear, vector(wire));
}

std::shared_ptr<Payload> twist_with_covariance(Wire& wire) {
  auto payload = twist(wire);
  numbers<36>(wire);
  return payload;
}

std::vector<float> floats(Wire& wire) {
  const auto count = wire.value<std::uint32_t>();
  if (count > wire.left() / sizeof(float)) throw Unusable("ends early");
  std::vector<float> values(count);
  for (float& value : values) value = wire.value<float>();
  return values;
}

std::shared_ptr<Payload> laser_scan(Wire& wire) {
  auto scan = std::make_shared<LaserScan>();
  scan->start_rad = static_cast<double>(wire.value<float>());
  wire.value<float>();  // the last angle
  scan->step_rad = static_cast<double>(wire.value<float>());
  scan->beam_interval_s = static_cast<double>(wire.value<float>());
  for (int i = 0; i < 3; ++i) wire.value<float>();  // time of a turn, limits
  scan->ranges_m = floats(wire);
  scan->intensities = floats(wire);
  if (!std::isfinite(scan->start_rad) || !std::isfinite(scan->step_rad) || scan->step_rad == 0.0)
    throw Unusable(fmt::format("a scan from {} rad in steps of {} rad", scan->start_rad, scan->step_rad));
  if (scan->ranges_m.empty()) throw Unusable("a scan without beams");
  if (!std::isfinite(scan->beam_interval_s)) throw Unusable("a scan whose time_increment is not finite");
  if (!scan->intensities.empty() && scan->intensities.size() != scan->ranges_m.size()) {
    throw Unusable(
        fmt::format("a scan of {} ranges, but {} intensities", scan->ranges_m.size(), scan->intensities.size()));
  }
  for (float& range : scan->ranges_m) {
    // As REP 117 has it: too near for the scanner is -infinity; no echo is +infinity, a fault NaN.
    if (range < 0.0f) range = 0.0f;
    if (std::isnan(range)) range = std::numeric_limits<float>::infinity();
  }
  std::ranges::replace_if(
      scan->intensities, [](float value) { return !std::isfinite(value); }, 0.0f);
  return scan;
}

/// How an image's channels lie in memory.
struct PixelOrder {
  std::string_view name;
  std::size_t channels;
  std::array<std::size_t, 3> bgr;  ///< where blue, green, red are
};

constexpr std::array<PixelOrder, 8> kPixelOrders = {{{"mono8", 1, {}},
                                                     {"8UC1", 1, {}},
                                                     {"bgr8", 3, {0, 1, 2}},
                                                     {"8UC3", 3, {0, 1, 2}},
                                                     {"rgb8", 3, {2, 1, 0}},
                                                     {"bgra8", 4, {0, 1, 2}},
                                                     {"8UC4", 4, {0, 1, 2}},
                                                     {"rgba8", 4, {2, 1, 0}}}};

std::shared_ptr<Payload> image(Wire& wire) {
  auto picture = std::make_shared<Image>();
  const std::size_t height = wire.value<std::uint32_t>();
  const std::size_t width = wire.value<std::uint32_t>();
  const std::string_view encoding = wire.text();
  wire.value<std::uint8_t>();  // the order of bytes: there is one byte per channel
  const std::size_t step = wire.value<std::uint32_t>();
  const Bytes data = wire.counted();
  const auto* const order = std::ranges::find(kPixelOrders, encoding, &PixelOrder::name);
  if (order == kPixelOrders.end()) {
    throw Unusable(
        fmt::format(R"(the encoding "{}" of an image is not supported; "bgr8", "rgb8" or "mono8" is expected)",
                    encoding.substr(0, 40)));
  }
  constexpr std::size_t kMost = 1 << 16;
  const bool fits = height > 0 && height <= kMost && width > 0 && width <= kMost && step >= width * order->channels &&
                    data.size() >= step * height;
  if (!fits) {
    throw Unusable(
        fmt::format("an image of {} x {} pixels in rows of {} bytes has {} bytes", width, height, step, data.size()));
  }
  picture->encoding = order->channels == 1 ? Image::Encoding::mono8 : Image::Encoding::bgr8;
  picture->width = static_cast<int>(width);
  picture->height = static_cast<int>(height);
  picture->data.reserve(width * height * std::min<std::size_t>(order->channels, 3));
  for (std::size_t row = 0; row < height; ++row) {
    const Bytes pixels = data.subspan(row * step, width * order->channels);
    if (order->channels == 1) {
      picture->data.insert(picture->data.end(), pixels.begin(), pixels.end());
      continue;
    }
    for (std::size_t i = 0; i < pixels.size(); i += order->channels) {
      for (const std::size_t channel : order->bgr) picture->data.push_back(pixels[i + channel]);
    }
  }
  return picture;
}

std::shared_ptr<Payload> compressed_image(Wire& wire) {
  auto picture = std::make_shared<Image>();
  picture->encoding = Image::Encoding::compressed;
  wire.text();  // the format stands in the file, too
  const Bytes data = wire.counted();
  picture->data.assign(data.begin(), data.end());
  return picture;
}

constexpr std::array<MessageKind, 10> kKinds = {
    {{"sensor_msgs/Imu", "6a62c6daae103f4ff57a132d6f95cec2", ImuSample::kType, imu},
     {"sensor_msgs/MagneticField", "2f3b0b43eed0c9501de0fa3ff89a45aa", MagneticField::kType, magnetic_field},
     {"sensor_msgs/NavSatFix", "2d3a8cd499b9b4a0249fb98fd05cfa48", GnssFix::kType, nav_sat_fix},
     {"nav_msgs/Odometry", "cd5e73d190d741a2f92e81eda573aca7", BodyTwist::kType, odometry_twist},
     {"nav_msgs/Odometry", "cd5e73d190d741a2f92e81eda573aca7", Height::kType, odometry_height},
     {"geometry_msgs/TwistStamped", "98d34b0043a2093cf9d9345ab6eef12e", BodyTwist::kType, twist},
     {"geometry_msgs/TwistWithCovarianceStamped", "8927a1a12fb2607ceea095b2dc440a96", BodyTwist::kType,
      twist_with_covariance},
     {"sensor_msgs/LaserScan", "90c7ef2dc6895d81024acba2ac42f369", LaserScan::kType, laser_scan},
     {"sensor_msgs/Image", "060021388200f6f0f447d0fcd9c64743", Image::kType, image},
     {"sensor_msgs/CompressedImage", "8f7a12909da2c9d3332d540a0977563f", Image::kType, compressed_image}}};

}  // namespace

std::span<const MessageKind> message_kinds() { return kKinds; }

Decoded decode(const MessageKind& kind, Bytes message) {
  Wire wire(message);
  // Every type read here begins with std_msgs/Header: sequence number, stamp, frame.
  wire.value<std::uint32_t>();
  const Time stamp = wire.time();
  wire.text();
  Decoded decoded;
  if (stamp != Time{}) decoded.stamp = stamp;
  decoded.payload = kind.decode(wire);
  if (wire.left() > 0) throw Unusable(fmt::format("{} bytes are left behind a {}", wire.left(), kind.type));
  return decoded;
}

}  // namespace waymark::rosbag1
