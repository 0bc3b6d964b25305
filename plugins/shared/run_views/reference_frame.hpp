// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "waymark/interface/snapshot.hpp"
#include "waymark/interface/source.hpp"
#include "waymark/math/pose.hpp"

namespace waymark::run_views {

/// Where a reference is at any time: between two points that are not far apart in time, on the line between them.
class ReferenceLookup {
 public:
  /// `reference` must outlive it; its stamps must not decrease.
  explicit ReferenceLookup(const Reference& reference);

  /// Nothing outside of the reference and in its pauses (over ten times its usual step, and over 1 s).
  std::optional<Pose> at(Time stamp) const;
  /// The first and the last pose before and after a pause, to break lines there.
  bool is_pause(std::size_t after) const;

 private:
  const std::vector<Reference::Point>& points_;
  Duration longest_step_{};
};

/// An estimate of a run with its uncertainty, to compare with a reference.
struct Estimate {
  Time stamp{};
  Pose T_map_base;
  double sigma_position_m = 0.0;  ///< the larger one of east and north
  double sigma_yaw_rad = 0.0;
};

/// How a reference comes into the map's frame.
struct ReferenceFrame {
  /// Rotation about z and translation; the identity if the frames are the same.
  Pose T_map_reference;
  bool is_aligned = false;  ///< T_map_reference is fitted
};

/// Decides whether a reference has a frame of its own (motion capture, another survey) and fits it then. It has one if
/// the estimate contradicts it at the start already (more than 5 σ in position or heading), and a rigid motion in the
/// plane takes away more than two thirds of all deviations (without headings: nine tenths). So what drifts from a
/// common start is not hidden. The fit is the one with the least sum of squares in the plane; height is shifted by the
/// mean.
ReferenceFrame frame_of(const Reference& reference, const std::vector<Estimate>& estimates);

/// The reference in the map's frame.
std::shared_ptr<const Reference> in_map(std::shared_ptr<const Reference> reference, const ReferenceFrame& frame);

}  // namespace waymark::run_views
