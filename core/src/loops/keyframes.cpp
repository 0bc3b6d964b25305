// SPDX-License-Identifier: Apache-2.0
#include "loops/keyframes.hpp"

#include <algorithm>

namespace waymark::loops {

void follow(std::span<Keyframe> keyframes, std::span<const StampedPose> path) {
  if (path.empty()) return;
  const auto first = std::ranges::lower_bound(keyframes, path.front().stamp, {}, &Keyframe::stamp);
  for (Keyframe& keyframe : keyframes.subspan(static_cast<std::size_t>(first - keyframes.begin()))) {
    const auto after = std::ranges::lower_bound(path, keyframe.stamp, {}, &StampedPose::stamp);
    if (after == path.end()) {
      keyframe.xyyaw = planar(path.back().T_map_base);
      continue;
    }
    const Eigen::Vector3d to = planar(after->T_map_base);
    if (after->stamp == keyframe.stamp) {
      keyframe.xyyaw = to;
      continue;
    }
    const auto before = after - 1;
    const Eigen::Vector3d from = planar(before->T_map_base);
    const double share = to_seconds(keyframe.stamp - before->stamp) / to_seconds(after->stamp - before->stamp);
    keyframe.xyyaw = interpolate(from, to, share);
  }
}

std::vector<Eigen::Vector2f> thinned(std::span<const Eigen::Vector2d> points) {
  constexpr std::size_t kMost = 180;
  const std::size_t step = 1 + points.size() / kMost;
  std::vector<Eigen::Vector2f> result;
  result.reserve(1 + points.size() / step);
  for (std::size_t i = 0; i < points.size(); i += step) result.emplace_back(points[i].cast<float>());
  return result;
}

std::vector<Eigen::Vector2f> window(std::span<const Keyframe> keyframes, std::size_t middle, double reach) {
  std::vector<Eigen::Vector2f> points;
  const Keyframe& own = keyframes[middle];
  const auto add = [&](const Keyframe& keyframe) {
    const Eigen::Vector3d relative = between(own.xyyaw, keyframe.xyyaw);
    const Eigen::Matrix2f R = rotation(relative.z()).cast<float>();
    const Eigen::Vector2f t = relative.head<2>().cast<float>();
    for (const Eigen::Vector2f& p : keyframe.points_base) points.emplace_back(R * p + t);
  };
  std::size_t first = middle;
  while (first > 0 && own.way - keyframes[first - 1].way <= reach) --first;
  for (std::size_t i = first; i < keyframes.size() && keyframes[i].way - own.way <= reach; ++i) add(keyframes[i]);
  return points;
}

}  // namespace waymark::loops
