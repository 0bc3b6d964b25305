// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "waymark/base/time.hpp"
#include "waymark/math/pose.hpp"

namespace waymark::evaluation {

/// The poses of both at one stamp of the reference.
struct PosePair {
  Time stamp;
  Pose estimate;
  Pose reference;
};

/// Errors over segments of the path, as the odometry benchmark of KITTI counts them (A. Geiger, P. Lenz, R. Urtasun,
/// "Are we ready for autonomous driving?", CVPR 2012): of segments of 100, 200, …, 800 m, whose beginnings are 1 s
/// apart, the motion that the estimate shows against that of the reference, per length.
struct SegmentErrors {
  struct Length {
    double length_m = 0.0;
    std::size_t segments = 0;
    double translation = 0.0;         ///< mean, share of the length
    double rotation_rad_per_m = 0.0;  ///< mean
  };
  std::vector<Length> by_length;  ///< those of which there is a segment
  Length all;                     ///< over all segments; `length_m` is their mean
};

/// Scores pairs in order of their stamps. No segments if the path is shorter than 100 m.
SegmentErrors score_segments(std::span<const PosePair> pairs);

}  // namespace waymark::evaluation
