// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "map_modules/feature_map/signature.hpp"
#include "waymark/interface/particle_map.hpp"

namespace waymark::feature_map {

/// One landmark as seen from the robot: position of its centre in the base frame and radius, (x, y, r), with one
/// covariance (4.1).
struct Detection {
  Eigen::Vector3d xyr = Eigen::Vector3d::Zero();  ///< [m]; r is meaningless where the map does not use it
  Eigen::Matrix3d R = Eigen::Matrix3d::Zero();    ///< noise covariance [m²]
  Signature signature;
  bool may_be_new = true;  ///< if it fits no landmark; false: only the scan supports it
  int identity = -1;       ///< what a device read off it (a barcode, a tag); -1: nothing
  int first_beam = -1;     ///< of the scan, for pictures
  int last_beam = -1;
};

/// How a planar scan saw the surroundings: what a landmark that was not detected must be compared with.
struct ScanView {
  Eigen::Vector2d p_base_sensor = Eigen::Vector2d::Zero();
  double yaw_base_sensor = 0.0;
  double start = 0.0;  ///< bearing of beam 0 [rad]
  double step = 0.0;
  /// From one beam to the next the sensor moved so far [m], in its own frame, while the scan was taken. Its turn is in
  /// `step`, its way along each beam in the ranges: the rest shifts what is near by a little.
  Eigen::Vector2d way_per_beam = Eigen::Vector2d::Zero();
  /// Cleaned ranges: +inf where nothing came back (free), 0 where the beam carries no information (the robot itself).
  std::vector<float> ranges;
};

/// What the feature map found in one measurement.
class FeatureObservation final : public Observation {
 public:
  Time stamp{};
  std::vector<Detection> detections;
  ScanView view;           ///< without ranges if the detections did not come from a scan
  double max_range = 0.0;  ///< farthest detection from the base [m]
};

}  // namespace waymark::feature_map
