// SPDX-License-Identifier: Apache-2.0
#include "odometry_steps.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "waymark/base/error.hpp"
#include "waymark/math/pose_increment.hpp"

namespace waymark::carmen {
namespace {

constexpr double kReversing = -0.01;  // [m/s]: below this the robot drives backward
constexpr double kShortest = 0.1;     // [s]: stamps jitter, so a shorter interval may stand for a longer one

Eigen::Vector3d vector(const PlanarPose& pose) { return {pose.x, pose.y, pose.theta}; }

/// The speed whose stamp is nearest; `speeds` are in order of their stamps.
std::optional<double> speed_near(const std::vector<OdometrySpeed>& speeds, Time at) {
  if (speeds.empty()) return std::nullopt;
  auto after = std::ranges::lower_bound(speeds, at, {}, &OdometrySpeed::stamp);
  if (after == speeds.end() || (after != speeds.begin() && at - std::prev(after)->stamp <= after->stamp - at)) --after;
  return after->tv_mps;
}

}  // namespace

OdometrySteps make_steps(const std::vector<OdometryPose>& poses, const std::vector<OdometrySpeed>& speeds,
                         const StepOptions& options, BadRecordList& bad) {
  OdometrySteps result;
  result.steps.reserve(poses.size());
  bool in_stretch = false;
  std::size_t last = 0;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const bool replaced = i + 1 < poses.size() && poses[i + 1].stamp == poses[i].stamp;
    if (replaced || poses[i].stamp == poses[last].stamp) continue;
    const OdometryPose& begin = poses[last];
    const OdometryPose& end = poses[i];
    last = i;
    const double interval_s = to_seconds(end.stamp - begin.stamp);
    auto increment =
        std::make_shared<PoseIncrement>(pose_increment(vector(begin.T_odom_base), vector(end.T_odom_base), interval_s));
    const double length = std::hypot(increment->x_m, increment->y_m);
    if (length > options.max_speed_mps * std::max(interval_s, kShortest)) {
      try {
        bad.add(end.place, fmt::format("odometry jumps by {:.3f} m in {:.3f} s; at most {} m/s are expected", length,
                                       interval_s, options.max_speed_mps));
      } catch (const DataError&) {
        result.failure = std::current_exception();
        return result;
      }
      continue;
    }
    const auto speed = speed_near(speeds, begin.stamp + (end.stamp - begin.stamp) / 2);
    const bool turned = options.repair_reversals && speed && *speed < kReversing && increment->x_m > 0.0;
    if (turned) {
      increment->x_m = -increment->x_m;
      increment->y_m = -increment->y_m;
      ++result.turned;
      result.turned_m += length;
      if (!in_stretch) ++result.stretches;
    }
    in_stretch = turned;
    result.steps.push_back({begin.stamp, end.stamp, std::move(increment)});
  }
  return result;
}

}  // namespace waymark::carmen
