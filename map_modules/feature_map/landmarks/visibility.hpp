// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "map_modules/feature_map/feature_map_settings.hpp"
#include "map_modules/feature_map/feature_observation.hpp"
#include "waymark/math/pose.hpp"

namespace waymark::feature_map {

/// What a sensor should see from one pose. Holds references to `view` and `settings`.
class ExpectedView {
 public:
  ExpectedView(const Pose& T_map_base, const ScanView& view, const ExistenceSettings& settings);

  /// True if the sensor must have seen a cylinder at `p_map` with `radius`: inside the field of view, and every beam
  /// over its width goes on beyond it. Where the detections did not come from a scan, the field of view of the settings
  /// decides alone.
  bool should_show(const Eigen::Vector2d& p_map, double radius) const;

  /// A disc in the map outside of which nothing should be seen: centre, and squared radius [m²].
  const Eigen::Vector2d& center() const { return center_; }
  double reach_square() const { return reach_square_; }

 private:
  /// The bearing, or that and a turn, whichever the scan's own angles hold; if neither, no beam goes there.
  double as_scanned(double bearing) const;
  /// True if a beam through the cylinder surely ends before it, so that its width need not be looked at.
  bool is_surely_hidden(const Eigen::Vector2d& p_sensor, double distance) const;

  const ScanView& view_;
  const ExistenceSettings& settings_;
  Eigen::Vector2d p_map_base_;
  Eigen::Matrix2d turn_;  ///< from a horizontal vector in the map to the sensor's plane
  Eigen::Vector2d p_offset_;
  double cos_half_angle_;
  double beams_per_radian_;
  Eigen::Vector2d center_;
  double reach_square_;
};

/// `ExpectedView::should_show` for one landmark.
bool should_be_seen(const Eigen::Vector2d& p_map, double radius, const Pose& T_map_base, const ScanView& view,
                    const ExistenceSettings& settings);

}  // namespace waymark::feature_map
