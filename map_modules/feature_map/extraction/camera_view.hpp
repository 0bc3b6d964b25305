// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "waymark/interface/rig.hpp"
#include "waymark/math/pose.hpp"

namespace waymark::feature_map {

/// A camera where it was when it took an image, in the base frame of the scan that the image belongs to.
class CameraView {
 public:
  /// `T_base_camera` has x forward, y left, z up, as the rig has it.
  CameraView(const Intrinsics& intrinsics, const Pose& T_base_camera);

  /// Where a point of the base frame lies in the image [px], the centre of the first pixel at (0, 0): pinhole with
  /// radial and tangential distortion (D. C. Brown, 1966). Nothing behind the camera, or so far aside that the
  /// distortion would fold it back into the image.
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& p_base) const;
  /// True if the pixel lies in the image.
  bool shows(const Eigen::Vector2d& pixel) const;

  const Eigen::Vector3d& p_base_camera() const { return p_base_camera_; }
  const Intrinsics& intrinsics() const { return intrinsics_; }

 private:
  Intrinsics intrinsics_;
  Pose T_camera_base_;
  Eigen::Vector3d p_base_camera_;
  double fold_square_;  // squared distance from the axis, at depth 1, where the distortion turns back
};

}  // namespace waymark::feature_map
