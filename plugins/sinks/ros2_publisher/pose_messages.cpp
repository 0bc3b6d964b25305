// SPDX-License-Identifier: Apache-2.0
#include "pose_messages.hpp"

#include <GeographicLib/LocalCartesian.hpp>
#include <algorithm>

#include "plugins/shared/cdr/to_ros.hpp"

namespace waymark::ros2_publisher {
namespace {

constexpr int kPoseStates = 0;
constexpr int kTwistStates = 6;

std::array<double, 36> row_by_row(const Eigen::Matrix<double, 6, 6>& P) {
  std::array<double, 36> numbers{};
  Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(numbers.data()) = P;
  return numbers;
}

ros::geometry_msgs::Vector3 to_vector(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

/// q and −q are the same rotation: one sign.
ros::geometry_msgs::Quaternion to_ros(const Eigen::Quaterniond& q) {
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;
  return {sign * q.x(), sign * q.y(), sign * q.z(), sign * q.w()};
}

ros::nav_msgs::Odometry odometry(const Belief& belief, const StateIndices& indices, const Frames& frames) {
  ros::nav_msgs::Odometry message;
  message.header.stamp = ros::to_ros_time(belief.stamp);
  message.child_frame_id = frames.base;
  message.twist.twist = {to_vector(belief.mean.v_base), to_vector(belief.mean.w_base)};
  message.twist.covariance = row_by_row(indices.covariance(belief, kTwistStates));
  return message;
}

}  // namespace

StateIndices::StateIndices(const StateLayout& layout) {
  for (std::size_t i = 0; i < active_.size(); ++i) active_[i] = layout.active(static_cast<int>(i));
}

Eigen::Matrix<double, 6, 6> StateIndices::covariance(const Belief& belief, int first) const {
  Eigen::Matrix<double, 6, 6> P = Eigen::Matrix<double, 6, 6>::Zero();
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 6; ++column) {
      const int i = active_.at(static_cast<std::size_t>(first + row));
      const int j = active_.at(static_cast<std::size_t>(first + column));
      if (i >= 0 && j >= 0) P(row, column) = belief.P(i, j);
    }
  }
  return P;
}

ros::geometry_msgs::Pose to_ros(const Pose& pose) { return {{pose.p.x(), pose.p.y(), pose.p.z()}, to_ros(pose.q)}; }

ros::geometry_msgs::TransformStamped to_ros(const Pose& T_parent_child, Time stamp, const std::string& parent,
                                            const std::string& child) {
  return {ros::to_ros_header(stamp, parent), child, {to_vector(T_parent_child.p), to_ros(T_parent_child.q)}};
}

ros::nav_msgs::Odometry odometry_in_map(const Belief& belief, const StateIndices& indices, const Frames& frames) {
  ros::nav_msgs::Odometry message = odometry(belief, indices, frames);
  message.header.frame_id = frames.map;
  message.pose = {to_ros(belief.mean.T_map_base), row_by_row(indices.covariance(belief, kPoseStates))};
  return message;
}

ros::nav_msgs::Odometry odometry_in_odom(const Belief& belief, const StateIndices& indices, const Frames& frames,
                                         const SmoothOdometry& smooth) {
  ros::nav_msgs::Odometry message = odometry(belief, indices, frames);
  message.header.frame_id = frames.odom;
  Eigen::Matrix<double, 6, 1> sigmas;
  sigmas << Eigen::Vector3d::Constant(smooth.position_sigma_m()),
      Eigen::Vector3d::Constant(smooth.rotation_sigma_rad());
  const Eigen::Matrix<double, 6, 6> P = sigmas.cwiseAbs2().asDiagonal();
  message.pose = {to_ros(smooth.T_odom_base()), row_by_row(P)};
  return message;
}

ros::geometry_msgs::PoseWithCovarianceStamped pose_in_map(const Belief& belief, const StateIndices& indices,
                                                          const Frames& frames) {
  return {ros::to_ros_header(belief.stamp, frames.map),
          {to_ros(belief.mean.T_map_base), row_by_row(indices.covariance(belief, kPoseStates))}};
}

ros::tf2_msgs::TFMessage transforms(const Belief& belief, const Frames& frames, const SmoothOdometry& smooth,
                                    Duration ahead) {
  const Pose T_map_odom = belief.mean.T_map_base * smooth.T_odom_base().inverse();
  return {{to_ros(T_map_odom, moved(belief.stamp, ahead).value_or(belief.stamp), frames.map, frames.odom),
           to_ros(smooth.T_odom_base(), belief.stamp, frames.odom, frames.base)}};
}

Eigen::Vector3d on_earth(const Eigen::Vector3d& p_map, const Datum& datum) {
  const GeographicLib::LocalCartesian frame(datum.latitude_deg, datum.longitude_deg, datum.height_m);
  Eigen::Vector3d place;
  frame.Reverse(p_map.x(), p_map.y(), p_map.z(), place.x(), place.y(), place.z());
  return place;
}

ros::sensor_msgs::NavSatFix fix(const Belief& belief, const StateIndices& indices, const Frames& frames,
                                const Datum& datum) {
  constexpr std::uint8_t kKnown = 3;
  ros::sensor_msgs::NavSatFix message;
  message.header = ros::to_ros_header(belief.stamp, frames.base);
  const Eigen::Vector3d place = on_earth(belief.mean.T_map_base.p, datum);
  message.latitude = place.x();
  message.longitude = place.y();
  message.altitude = place.z();
  message.status.service = 1;
  const Eigen::Matrix3d P = indices.covariance(belief, kPoseStates).topLeftCorner<3, 3>();
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(message.position_covariance.data()) = P;
  message.position_covariance_type = kKnown;
  return message;
}

}  // namespace waymark::ros2_publisher
