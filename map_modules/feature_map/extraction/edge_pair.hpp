// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "map_modules/feature_map/extraction/camera_view.hpp"

namespace waymark::feature_map {

/// A piece of an image, resampled onto an upright plane through the axis of a candidate that faces the camera. The
/// silhouette of an upright cylinder is two columns there, whatever the camera's tilt and lens distortion.
struct UprightPatch {
  cv::Mat bgr;               ///< row 0 is the top
  double first_slope = 0.0;  ///< of column 0: tangent of the angle from the axis, to the right, as the camera sees it
  double slope_step = 0.0;   ///< per column; about one pixel
  double distance = 0.0;     ///< from the camera to the axis, in the plane [m]
  double top = 0.0;          ///< height of row 0 above the scan [m]
  double height_step = 0.0;  ///< per row, downwards [m]
  Eigen::Vector3d p_base_axis = Eigen::Vector3d::Zero();  ///< where the scan meets the axis
  Eigen::Vector3d right = Eigen::Vector3d::Zero();        ///< unit vector of the base frame, along a row

  double slope(double column) const { return first_slope + column * slope_step; }
  double column(double slope) const { return (slope - first_slope) / slope_step; }
  /// The place that a column and row show, in the base frame.
  Eigen::Vector3d p_base(double column, double row) const;
};

/// The rows from `below` to `above` the scan [m] that the image shows over the whole width, `half_slope` to both sides.
/// Nothing if it shows too few, or the camera stands on the spot.
std::optional<UprightPatch> sample_patch(const cv::Mat& bgr, const CameraView& camera,
                                         const Eigen::Vector3d& p_base_axis, double half_slope, double below,
                                         double above);

/// Contrast of every column's vertical edge: the step of brightness [grey levels] between the two columns before and
/// the two after it, in the channel with most of it, in eight bands of rows, each averaged first, since texture
/// averages out and a silhouette does not; of these the one that a share `min_cover` of the bands reaches, since what
/// ends within the height, a stone or a box, is no pole.
std::vector<float> vertical_contrast(const cv::Mat& bgr, double min_cover);

/// The borders of a candidate in a patch, in columns (with fractions).
struct EdgePair {
  double left = 0.0;
  double right = 0.0;
};

/// What is expected of a pair.
struct EdgeSearch {
  double reach;         ///< columns, about each predicted border
  double min_contrast;  ///< grey levels
  double min_ratio;     ///< of the width to that predicted
  double max_ratio;
};

/// The pair of local maxima of contrast near the predicted borders with most contrast, the nearer the better. Nothing
/// if there is none.
std::optional<EdgePair> find_edge_pair(const std::vector<float>& contrast, const EdgePair& predicted,
                                       const EdgeSearch& search);

}  // namespace waymark::feature_map
