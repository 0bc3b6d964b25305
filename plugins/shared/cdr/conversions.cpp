// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/cdr/conversions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>

#include "waymark/math/pose_increment.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::ros {
namespace {

Eigen::Vector3d vector(const geometry_msgs::Vector3& v) { return {v.x, v.y, v.z}; }

void require_finite(const Eigen::Vector3d& v, std::string_view what) {
  if (!v.allFinite()) throw Unusable(fmt::format("the {} is ({}, {}, {}), not finite", what, v.x(), v.y(), v.z()));
}

/// A covariance whose first number is -1 means that there is no such measurement.
bool is_absent(const std::array<double, 9>& covariance) { return covariance[0] == -1.0; }

/// The σ that a variance stands for; zero, negative or NaN: unknown.
double sigma_of(double variance) {
  return variance > 0.0 && std::isfinite(variance) ? std::sqrt(variance) : std::numeric_limits<double>::quiet_NaN();
}

/// A rotation of length 1. Throws Unusable for one that is off by more than 1 %.
Eigen::Quaterniond unit(const geometry_msgs::Quaternion& q) {
  constexpr double kLoose = 0.01;
  constexpr double kTight = 1e-9;  // what was normalised once stays as it is, bit by bit
  const Eigen::Quaterniond orientation(q.w, q.x, q.y, q.z);
  const double norm = orientation.norm();
  if (!(std::abs(norm - 1.0) < kLoose))
    throw Unusable(fmt::format("the orientation ({}, {}, {}, {}) is not a unit quaternion", q.x, q.y, q.z, q.w));
  return std::abs(norm - 1.0) < kTight ? orientation : orientation.normalized();
}

}  // namespace

std::optional<Time> to_time(const builtin_interfaces::Time& time) {
  if (time.sec == 0 && time.nanosec == 0) return std::nullopt;
  const auto seconds = std::int64_t{static_cast<std::uint32_t>(time.sec)};
  return Time{Duration{seconds * 1'000'000'000 + time.nanosec}};
}

std::shared_ptr<ImuSample> to_imu_sample(const sensor_msgs::Imu& message) {
  auto sample = std::make_shared<ImuSample>();
  if (!is_absent(message.angular_velocity_covariance)) {
    sample->w_sensor = vector(message.angular_velocity);
    require_finite(sample->w_sensor, "angular velocity");
  }
  if (!is_absent(message.linear_acceleration_covariance)) {
    sample->f_sensor = vector(message.linear_acceleration);
    require_finite(sample->f_sensor, "linear acceleration");
  }
  const auto& q = message.orientation;
  const bool is_zero = q.w == 0.0 && q.x == 0.0 && q.y == 0.0 && q.z == 0.0;
  if (!is_absent(message.orientation_covariance) && !is_zero) {
    sample->q_enu_sensor = unit(q);
  } else if (is_absent(message.angular_velocity_covariance)) {
    throw Unusable("it has neither an angular velocity nor an orientation");
  }
  return sample;
}

std::shared_ptr<MagneticField> to_magnetic_field(const sensor_msgs::MagneticField& message) {
  auto field = std::make_shared<MagneticField>();
  field->m_sensor = vector(message.magnetic_field);
  require_finite(field->m_sensor, "magnetic field");
  return field;
}

std::shared_ptr<GnssFix> to_gnss_fix(const sensor_msgs::NavSatFix& message) {
  auto fix = std::make_shared<GnssFix>();
  const std::int8_t status = message.status.status;  // negative: no fix
  fix->type = status < 0    ? GnssFix::Type::none
              : status == 0 ? GnssFix::Type::single
              : status <= 2 ? GnssFix::Type::differential
                            : GnssFix::Type::unknown;
  const bool known = std::isfinite(message.latitude) && std::isfinite(message.longitude);
  // Some drivers leave the status of a message without position at 0.
  if (!known) fix->type = GnssFix::Type::none;
  if (known) {
    if (std::abs(message.latitude) > 90.0)
      throw Unusable(fmt::format("{} is not a latitude (-90 to 90 deg)", message.latitude));
    fix->latitude_deg = message.latitude;
    fix->longitude_deg = message.longitude;
    if (std::isfinite(message.altitude)) fix->height_m = message.altitude;
  }
  if (message.position_covariance_type != 0) {
    fix->sigma_horizontal_m = sigma_of(0.5 * (message.position_covariance[0] + message.position_covariance[4]));
    fix->sigma_vertical_m = sigma_of(message.position_covariance[8]);
  }
  return fix;
}

std::shared_ptr<LaserScan> to_laser_scan(sensor_msgs::LaserScan message) {
  auto scan = std::make_shared<LaserScan>();
  scan->start_rad = static_cast<double>(message.angle_min);
  scan->step_rad = static_cast<double>(message.angle_increment);
  scan->beam_interval_s = static_cast<double>(message.time_increment);
  scan->ranges_m = std::move(message.ranges);
  scan->intensities = std::move(message.intensities);
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

std::shared_ptr<BodyTwist> to_body_twist(const geometry_msgs::Twist& message) {
  require_finite(vector(message.linear), "linear velocity");
  require_finite(vector(message.angular), "angular velocity");
  auto twist = std::make_shared<BodyTwist>();
  twist->v_x_mps = message.linear.x;
  twist->v_y_mps = message.linear.y;
  twist->w_z_radps = message.angular.z;
  return twist;
}

std::shared_ptr<Height> to_height(const geometry_msgs::Pose& pose) {
  require_finite({pose.position.x, pose.position.y, pose.position.z}, "position");
  auto height = std::make_shared<Height>();
  height->height_m = pose.position.z;
  return height;
}

std::shared_ptr<Height> to_height(const geometry_msgs::PoseWithCovariance& pose) {
  constexpr std::size_t kVarianceOfZ = 2 * 6 + 2;
  auto height = to_height(pose.pose);
  height->sigma_m = sigma_of(pose.covariance[kVarianceOfZ]);
  return height;
}

std::shared_ptr<WheelSpeeds> to_wheel_speeds(const sensor_msgs::JointState& message, const WheelJoints& joints) {
  const auto mean_of = [&](const std::vector<std::string>& names) {
    double sum = 0.0;
    for (const std::string& name : names) {
      const auto at = static_cast<std::size_t>(std::ranges::find(message.name, name) - message.name.begin());
      if (at == message.name.size()) throw Unusable(fmt::format("it has no joint \"{}\"", name));
      if (at >= message.velocity.size() || !std::isfinite(message.velocity[at]))
        throw Unusable(fmt::format("the joint \"{}\" has no velocity", name));
      sum += message.velocity[at];
    }
    return joints.radius_m * sum / static_cast<double>(names.size());
  };
  auto speeds = std::make_shared<WheelSpeeds>();
  speeds->left_mps = mean_of(joints.left);
  speeds->right_mps = mean_of(joints.right);
  return speeds;
}

std::optional<IncrementsOfPoses::Increment> IncrementsOfPoses::add(Time stamp, const geometry_msgs::Pose& pose) {
  require_finite({pose.position.x, pose.position.y, pose.position.z}, "position");
  const Eigen::Vector3d end(pose.position.x, pose.position.y, so3::yaw(unit(pose.orientation)));
  if (last_ && stamp <= last_->first) throw Unusable("its stamp does not lie after that of the pose before");
  const auto begin = std::exchange(last_, std::pair(stamp, end));
  if (!begin) return std::nullopt;
  return Increment{begin->first, std::make_shared<PoseIncrement>(
                                     pose_increment(begin->second, end, to_seconds(stamp - begin->first)))};
}

}  // namespace waymark::ros
