// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "loops/planar.hpp"
#include "waymark/base/time.hpp"
#include "waymark/interface/particle_map.hpp"
#include "waymark/interface/snapshot.hpp"

namespace waymark::loops {

/// An observation that one of the maps has taken.
struct MapObservation {
  int module = 0;
  std::shared_ptr<const Observation> observation;
};

/// A mapping step as the maps can be drawn again from: what was observed, and how the pose was known.
struct Keyframe {
  Time stamp;
  std::vector<MapObservation> observations;
  std::vector<Eigen::Vector2f> points_base;  ///< of surfaces, thinned [m]
  std::size_t points = 0;                    ///< of surfaces before they were thinned: what drawing it costs
  /// What this step adds to the error of the path: covariance of (x, y, yaw), in the axes of the map as it was then.
  Eigen::Matrix3d P = Eigen::Matrix3d::Zero();
  Pose T_map_base;                                  ///< as it was taken: z, roll and pitch do not change
  Eigen::Vector3d xyyaw = Eigen::Vector3d::Zero();  ///< of the base, in the map of the best particle
  std::optional<std::uint64_t> anchor;              ///< of the joint Gaussian, that new places belonged to
  double way = 0.0;                                 ///< driven up to here [m]
};

/// Sets the poses of keyframes to those of a path with the same stamps; between two stamps, interpolated. Those before
/// the path stay, those after it have its last pose. Keyframes and path are in order.
WAYMARK_API void follow(std::span<Keyframe> keyframes, std::span<const StampedPose> path);

/// Points of one scan, as many as a window needs [m].
WAYMARK_API std::vector<Eigen::Vector2f> thinned(std::span<const Eigen::Vector2d> points);

/// The points of the keyframes within `reach` [m] of way of the one at `middle`, in its frame.
std::vector<Eigen::Vector2f> window(std::span<const Keyframe> keyframes, std::size_t middle, double reach);

}  // namespace waymark::loops
