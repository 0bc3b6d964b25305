// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "joint/joint_gaussian.hpp"
#include "joint/place_grid.hpp"
#include "waymark/base/api.hpp"
#include "waymark/host/filter_settings.hpp"

namespace waymark::joint {

/// The anchors of dense maps: poses of the path from which the places around them were first mapped. A scan that
/// matches such places relates the pose to their anchors, whatever way led there. An anchor has noise of its own: what
/// was mapped from it lies wrong by so much, together, and no number of scans averages that.
class WAYMARK_API Anchors {
 public:
  explicit Anchors(const JointSettings& settings) : settings_(settings), spacing_(settings.anchor_spacing) {}

  /// Relates the pose to the anchors of the places that `points` (in the map) lie in, each by its share of
  /// `information` about (x, y, yaw).
  void relate(JointGaussian& gaussian, const Eigen::Matrix3d& information, std::span<const Eigen::Vector2d> points);
  /// The places of `points` that have no anchor get the one of this pose, which is added where none is near.
  void claim(JointGaussian& gaussian, std::span<const Eigen::Vector2d> points);

  void clear();
  std::size_t size() const { return anchors_.size(); }

  template <class Archive>
  void serialize(Archive& archive, const JointGaussian& gaussian);

 private:
  struct Anchor {
    JointGaussian::NodeId node;
    Eigen::Vector2d p_map;
  };
  struct Share {
    int anchor;
    int points;
  };

  void choose_active(JointGaussian& gaussian);
  void thin(JointGaussian& gaussian);
  int nearest(const Eigen::Vector2d& p_map, double within) const;

  JointSettings settings_;
  double spacing_;  // grows as the anchors are thinned
  std::vector<Anchor> anchors_;
  int active_ = PlaceGrid::kNone;  // new places belong to it
  PlaceGrid places_;
  std::vector<Share> shares_;  // of the last scan: anchors by their number of points, the largest first
};

}  // namespace waymark::joint
