// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <string>

namespace waymark::ros2_publisher {

/// What is published, and as which topics.
struct Topics {
  std::set<std::string, std::less<>> wanted;  ///< words of the key `publish`
  std::string odometry, odometry_in_map, pose, fix, path, map, landmarks, octomap, diagnostics;

  bool has(std::string_view word) const { return wanted.contains(word); }
};

}  // namespace waymark::ros2_publisher
