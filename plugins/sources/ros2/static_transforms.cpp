// SPDX-License-Identifier: Apache-2.0
#include "static_transforms.hpp"

#include <fmt/format.h>

#include <cmath>
#include <string_view>
#include <utility>

#include "plugins/shared/cdr/wire_reader.hpp"

namespace waymark::ros2 {
namespace {

constexpr std::size_t kMostFrames = 1000;
constexpr std::size_t kLongestName = 255;
constexpr int kDeepest = 100;  // of a chain of frames; a circle has no end

/// Names of frames in ROS 1 began with a slash.
std::string name_of(const std::string& frame) { return frame.starts_with('/') ? frame.substr(1) : frame; }

}  // namespace

void StaticTransforms::add(const ros::tf2_msgs::TFMessage& message) {
  std::map<std::string, Edge> edges = edges_;
  for (const auto& one : message.transforms) {
    const auto& q = one.transform.rotation;
    const auto& p = one.transform.translation;
    const Eigen::Quaterniond rotation(q.w, q.x, q.y, q.z);
    const Eigen::Vector3d translation(p.x, p.y, p.z);
    constexpr double kLoose = 0.01;
    if (!translation.allFinite() || !(std::abs(rotation.norm() - 1.0) < kLoose)) {
      throw ros::Unusable(fmt::format("the transform to {} is no rotation and translation",
                                      std::string_view(one.child_frame_id).substr(0, 40)));
    }
    if (one.child_frame_id.empty() || one.child_frame_id.size() > kLongestName ||
        one.header.frame_id.size() > kLongestName)
      throw ros::Unusable("a frame has no name, or one of more than 255 bytes");
    if (edges.size() >= kMostFrames && !edges.contains(name_of(one.child_frame_id))) continue;
    edges[name_of(one.child_frame_id)] = {name_of(one.header.frame_id), {rotation.normalized(), translation}};
  }
  edges_ = std::move(edges);
}

std::pair<std::string, Pose> StaticTransforms::root_of(std::string frame) const {
  Pose T_root_frame;
  for (int depth = 0; depth < kDeepest; ++depth) {
    const auto edge = edges_.find(frame);
    if (edge == edges_.end()) break;
    T_root_frame = edge->second.T_parent_child * T_root_frame;
    frame = edge->second.parent;
  }
  return {std::move(frame), T_root_frame};
}

std::optional<Pose> StaticTransforms::find(const std::string& base, const std::string& frame) const {
  const auto [root_of_base, T_root_base] = root_of(name_of(base));
  const auto [root_of_frame, T_root_frame] = root_of(name_of(frame));
  if (root_of_base != root_of_frame) return std::nullopt;
  const Pose T_base_frame = T_root_base.inverse() * T_root_frame;
  if (!T_base_frame.p.allFinite()) return std::nullopt;  // of a chain of huge numbers
  return T_base_frame;
}

std::string StaticTransforms::list() const {
  constexpr std::size_t kLongest = 500;
  std::string text;
  for (const auto& [child, edge] : edges_) {
    if (text.size() > kLongest) return text + ", …";
    text += fmt::format("{}{} (in {})", text.empty() ? "" : ", ", child, edge.parent);
  }
  return text.empty() ? "none" : text;
}

}  // namespace waymark::ros2
