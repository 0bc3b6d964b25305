// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "plugins/shared/cdr/ros/geometry_msgs.hpp"
#include "plugins/shared/cdr/ros/nav_msgs.hpp"
#include "plugins/shared/cdr/ros/sensor_msgs.hpp"
#include "plugins/shared/cdr/ros/std_msgs.hpp"
#include "plugins/shared/cdr/wire_reader.hpp"
#include "waymark/interface/payloads.hpp"

/// Messages of ROS as payloads. All throw Unusable for values that are not finite, or contradict each other.
namespace waymark::ros {

/// Nothing for a stamp of zero. Seconds count as unsigned, as in ROS 1: until 2106.
std::optional<Time> to_time(const builtin_interfaces::Time& time);

/// The first number of a covariance is −1: not measured.
std::shared_ptr<ImuSample> to_imu_sample(const sensor_msgs::Imu& message);
std::shared_ptr<MagneticField> to_magnetic_field(const sensor_msgs::MagneticField& message);
std::shared_ptr<GnssFix> to_gnss_fix(const sensor_msgs::NavSatFix& message);
/// REP 117: −∞ (too near) becomes 0; NaN (a fault) +∞, as no echo.
std::shared_ptr<LaserScan> to_laser_scan(sensor_msgs::LaserScan message);
std::shared_ptr<Image> to_image(const sensor_msgs::Image& message);
std::shared_ptr<Image> to_image(sensor_msgs::CompressedImage message);
/// x, y, z (float32 or float64); `intensity`; the times of the points from `t`, `time`, `time_stamp`, `timestamp` or
/// `offset_time`: seconds after the stamp as floats, nanoseconds as whole numbers, and seconds since 1970 as float64
/// if they are more than a year. Points without a finite position are left out.
std::shared_ptr<PointCloud> to_point_cloud(const sensor_msgs::PointCloud2& message);
std::shared_ptr<BodyTwist> to_body_twist(const geometry_msgs::Twist& twist);
/// The height and its variance.
std::shared_ptr<Height> to_height(const geometry_msgs::PoseWithCovariance& pose);
std::shared_ptr<Height> to_height(const geometry_msgs::Pose& pose);

/// Which joints are wheels.
struct WheelJoints {
  std::vector<std::string> left, right;  ///< the mean of each side counts
  double radius_m = 0.0;
};

/// Throws Unusable for a joint that the message lacks, or one without velocity.
std::shared_ptr<WheelSpeeds> to_wheel_speeds(const sensor_msgs::JointState& message, const WheelJoints& joints);

/// Motion from one pose to the next one, of odometry that is given as poses.
class IncrementsOfPoses {
 public:
  struct Increment {
    Time stamp;                              ///< of the pose before
    std::shared_ptr<PoseIncrement> payload;  ///< never null
  };

  /// Nothing for the first pose. Throws Unusable if the stamp does not lie after the last one, and for what is not a
  /// pose.
  std::optional<Increment> add(Time stamp, const geometry_msgs::Pose& pose);

 private:
  std::optional<std::pair<Time, Eigen::Vector3d>> last_;  // x, y, yaw
};

}  // namespace waymark::ros
