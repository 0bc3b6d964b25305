// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <string_view>

#include "waymark/interface/health.hpp"
#include "waymark/interface/nav_state.hpp"

namespace waymark::json_poses {

/// What a belief is written with. The layout of the states is copied, for it is valid during a call only.
class Estimate {
 public:
  explicit Estimate(const StateLayout& layout);

  /// Covariance of x, y, z and the rotations about the map's x, y, z; zero where the motion is planar.
  Eigen::Matrix<double, 6, 6> pose_covariance(const Belief& belief) const;

 private:
  std::array<int, 6> active_{};
};

/// `{"type":"pose","stamp_ns":…,"x_m":…}` with an end of the line.
std::string pose_line(const Belief& belief, const Estimate& estimate, const Health& health);

/// The velocity of the base as a message of the payload BodyTwist, with an end of the line.
std::string twist_line(const Belief& belief, std::string_view sensor);

/// The position of the base as a message of the payload GnssFix, in the map, with an end of the line.
std::string fix_line(const Belief& belief, const Estimate& estimate, std::string_view sensor);

}  // namespace waymark::json_poses
