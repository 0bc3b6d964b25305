// SPDX-License-Identifier: Apache-2.0
// What the source ros2 reads beside measurements: transforms of sensors, poses of RViz, the clock. The first byte of an
// input selects.
#include <cmath>
#include <string>

#include "plugins/shared/cdr/conversions.hpp"
#include "plugins/shared/cdr/message.hpp"
#include "plugins/shared/cdr/ros/std_msgs.hpp"
#include "plugins/shared/dds/names.hpp"
#include "plugins/sources/ros2/initial_pose.hpp"
#include "plugins/sources/ros2/static_transforms.hpp"
#include "tests/fuzz/harness.hpp"
#include "tests/fuzz/input.hpp"

namespace waymark::fuzz::ros2_harness {
namespace {

ros::Bytes bytes_of(std::string_view text) { return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}; }

void read_transforms(std::string_view rest) {
  const auto message = ros::from_cdr<ros::tf2_msgs::TFMessage>(bytes_of(rest));
  ros2::StaticTransforms transforms;
  transforms.add(message);
  for (const auto& one : message.transforms) {
    const auto pose = transforms.find("base_link", one.child_frame_id);
    if (pose && (std::abs(pose->q.norm() - 1.0) > 1e-6)) violation("a transform has no rotation");
  }
  (void)transforms.list();
}

void read_pose(std::string_view rest) {
  const auto message = ros::from_cdr<ros::geometry_msgs::PoseWithCovarianceStamped>(bytes_of(rest));
  const std::string command = ros2::set_pose_command(message, "map");
  if (command.find("nan") != std::string::npos || command.find("inf") != std::string::npos)
    violation("a command has no numbers: " + command);
}

void run(std::string_view input) {
  const Choice what = choose(input, 4);
  try {
    if (what.which == 0) read_transforms(what.rest);
    if (what.which == 1) read_pose(what.rest);
    if (what.which == 2) (void)ros::to_time(ros::from_cdr<ros::rosgraph_msgs::Clock>(bytes_of(what.rest)).clock);
    if (what.which == 3) (void)dds::ros_type(what.rest);
  } catch (const ros::Unusable&) {
    // the message is refused
  }
}

const Harness kHarness("ros2", run);

}  // namespace
}  // namespace waymark::fuzz::ros2_harness
