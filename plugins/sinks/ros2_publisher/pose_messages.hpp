// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>

#include "plugins/shared/cdr/ros/geometry_msgs.hpp"
#include "plugins/shared/cdr/ros/nav_msgs.hpp"
#include "plugins/shared/cdr/ros/sensor_msgs.hpp"
#include "smooth_odometry.hpp"
#include "waymark/interface/nav_state.hpp"
#include "waymark/interface/sensor.hpp"

namespace waymark::ros2_publisher {

/// Names of the frames of REP 105.
struct Frames {
  std::string map, odom, base;
};

/// Where the states lie in a belief's covariance. The filter's own list of them is valid during a call only.
class StateIndices {
 public:
  explicit StateIndices(const StateLayout& layout);
  /// Covariance of x, y, z and the rotations about x, y, z; zero for what planar motion holds fixed. `first`: 0: of the
  /// pose in the map, 6: of the twist in the base frame.
  Eigen::Matrix<double, 6, 6> covariance(const Belief& belief, int first) const;

 private:
  std::array<int, kCoreStates> active_{};
};

ros::geometry_msgs::Pose to_ros(const Pose& pose);
ros::geometry_msgs::TransformStamped to_ros(const Pose& T_parent_child, Time stamp, const std::string& parent,
                                            const std::string& child);

/// The pose in the map, with velocity in the frame of the base.
ros::nav_msgs::Odometry odometry_in_map(const Belief& belief, const StateIndices& indices, const Frames& frames);
/// The smooth pose, with the same velocity.
ros::nav_msgs::Odometry odometry_in_odom(const Belief& belief, const StateIndices& indices, const Frames& frames,
                                         const SmoothOdometry& smooth);
ros::geometry_msgs::PoseWithCovarianceStamped pose_in_map(const Belief& belief, const StateIndices& indices,
                                                          const Frames& frames);
/// map → odom → base. `ahead`: how much later than the belief map → odom is said to be valid.
ros::tf2_msgs::TFMessage transforms(const Belief& belief, const Frames& frames, const SmoothOdometry& smooth,
                                    Duration ahead);
/// The position on the Earth; the map is east, north, up around `datum`.
ros::sensor_msgs::NavSatFix fix(const Belief& belief, const StateIndices& indices, const Frames& frames,
                                const Datum& datum);
/// Latitude, longitude [degrees] and height [m] of a point of the map.
Eigen::Vector3d on_earth(const Eigen::Vector3d& p_map, const Datum& datum);

}  // namespace waymark::ros2_publisher
