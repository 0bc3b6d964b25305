// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "joint/joint_gaussian.hpp"
#include "waymark/base/api.hpp"
#include "waymark/interface/particle_map.hpp"
#include "waymark/math/pose.hpp"

namespace waymark::joint {

/// A match about all six of the pose: the likelihood exp(ηᵀ d − ½ dᵀ Λ d) of d = pose ⊟ `prior`.
struct SpatialMatch {
  Pose prior;
  SpatialInformation about;  ///< Λ and η
};

/// Height, roll and pitch of a map itself, as a node of (z [m], rotation about x, rotation about y [rad]) at its
/// origin. The map was begun at the height and the tilt that the robot was believed to have. A match says how the robot
/// stands to the map, and nothing about how the map stands to gravity: 0.1° of that is 3 cm of height at 20 m.
class WAYMARK_API FrameNode {
 public:
  void clear() { node_.reset(); }
  bool has_begun() const { return node_.has_value(); }
  /// The map begins at this pose.
  void begin(JointGaussian& gaussian);
  /// Updates height, roll and pitch with what a match says about them whatever x, y and yaw are. The map is certain if
  /// it has not begun in this run.
  void relate(JointGaussian& gaussian, const SpatialMatch& match) const;

  /// Reading throws DataError if `gaussian` does not have the node.
  template <class Archive>
  void serialize(Archive& archive, const JointGaussian& gaussian);

 private:
  std::optional<JointGaussian::NodeId> node_;
};

}  // namespace waymark::joint
