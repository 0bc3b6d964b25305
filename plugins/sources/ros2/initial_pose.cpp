// SPDX-License-Identifier: Apache-2.0
#include "initial_pose.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <string_view>

#include "plugins/shared/cdr/wire_reader.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::ros2 {

std::string set_pose_command(const ros::geometry_msgs::PoseWithCovarianceStamped& message,
                             const std::string& map_frame) {
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  constexpr std::size_t kY = 7;
  constexpr std::size_t kYaw = 35;
  const std::string& frame = message.header.frame_id;
  if ((frame.starts_with('/') ? frame.substr(1) : frame) != map_frame) {
    throw ros::Unusable(
        fmt::format("the pose is in the frame \"{}\"; \"{}\" is expected", frame.substr(0, 40), map_frame));
  }
  const auto& [pose, covariance] = message.pose;
  const auto& q = pose.orientation;
  const Eigen::Quaterniond orientation(q.w, q.x, q.y, q.z);
  constexpr double kLoose = 0.01;
  const bool is_pose =
      std::isfinite(pose.position.x) && std::isfinite(pose.position.y) && std::abs(orientation.norm() - 1.0) < kLoose;
  if (!is_pose) throw ros::Unusable("the pose has numbers that are not finite, or a rotation that is none");
  std::string command =
      fmt::format("set-pose {} {} {}", pose.position.x, pose.position.y, kDegrees * so3::yaw(orientation.normalized()));
  const double position_variance = 0.5 * (covariance[0] + covariance[kY]);
  const double yaw_variance = covariance[kYaw];
  const bool is_known =
      position_variance > 0.0 && yaw_variance > 0.0 && std::isfinite(position_variance) && std::isfinite(yaw_variance);
  if (is_known) command += fmt::format(" {} {}", std::sqrt(position_variance), kDegrees * std::sqrt(yaw_variance));
  return command;
}

}  // namespace waymark::ros2
