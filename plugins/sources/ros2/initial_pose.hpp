// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "plugins/shared/cdr/ros/geometry_msgs.hpp"

namespace waymark::ros2 {

/// The command that begins anew at the pose that RViz gives: "set-pose 1 2 90 0.5 15". Throws Unusable for a pose in
/// another frame than `map_frame`, and for values that are no pose.
std::string set_pose_command(const ros::geometry_msgs::PoseWithCovarianceStamped& message,
                             const std::string& map_frame);

}  // namespace waymark::ros2
