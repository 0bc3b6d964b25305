// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>

#include "plugins/shared/cdr/ros/geometry_msgs.hpp"
#include "waymark/math/pose.hpp"

namespace waymark::ros2 {

/// The frames of a robot that do not move against each other, as /tf_static has them.
class StaticTransforms {
 public:
  /// Adds the transforms of a message, each in place of an older one to the same child. Throws Unusable, and adds
  /// nothing, for values that are no transform. At most 1000 frames are kept; more are ignored.
  void add(const ros::tf2_msgs::TFMessage& message);

  /// T_base_frame; nothing if the two are not connected.
  std::optional<Pose> find(const std::string& base, const std::string& frame) const;
  /// "laser (in base_link), camera (in laser)", or "none".
  std::string list() const;

 private:
  struct Edge {
    std::string parent;
    Pose T_parent_child;
  };
  /// T_root_frame, and the name of the root.
  std::pair<std::string, Pose> root_of(std::string frame) const;

  std::map<std::string, Edge> edges_;  // by child
};

}  // namespace waymark::ros2
