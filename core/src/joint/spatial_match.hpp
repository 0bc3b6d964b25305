// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "joint/joint_gaussian.hpp"
#include "waymark/interface/map_module.hpp"
#include "waymark/math/pose.hpp"

namespace waymark::joint {

/// A match about all six of the pose: the likelihood exp(ηᵀ d − ½ dᵀ Λ d) of d = pose ⊟ `prior`.
struct SpatialMatch {
  Pose prior;
  SpatialInformation about;  ///< Λ and η
};

/// Updates height, roll and pitch with what a match says about them whatever x, y and yaw are. Anchors have x, y and
/// yaw only, so the map's own error in height and tilt does not count.
void relate_height_and_tilt(JointGaussian& gaussian, const SpatialMatch& match);

}  // namespace waymark::joint
