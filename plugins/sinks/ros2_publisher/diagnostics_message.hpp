// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "plugins/shared/cdr/ros/diagnostic_msgs.hpp"
#include "waymark/interface/snapshot.hpp"

namespace waymark::ros2_publisher {

/// Health of the pose and of each sensor. `sensors`: their names, in the order of the rig.
ros::diagnostic_msgs::DiagnosticArray diagnostics_message(const Health& health, const std::vector<std::string>& sensors,
                                                          Time stamp);

}  // namespace waymark::ros2_publisher
