// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>
#include <vector>

#include "waymark/map_module.hpp"

namespace waymark {

/// Bins of a signature, the discrete distribution that describes how a landmark looks (4.7). Two for reflectivity:
/// dark, bright.
inline constexpr int kSignatureBins = 2;
using Signature = std::array<float, kSignatureBins>;

/// One landmark as seen from the robot: position of its centre in the base frame and radius, (x, y, r), with one
/// covariance (4.1).
struct Detection {
  Eigen::Vector3d xyr = Eigen::Vector3d::Zero();  ///< [m]; r is meaningless where the map does not use it
  Eigen::Matrix3d R = Eigen::Matrix3d::Zero();    ///< noise covariance [m²]
  Signature signature{};
  int first_beam = -1;  ///< of the scan, for pictures
  int last_beam = -1;
};

/// How a planar scan saw the surroundings: what a landmark that was not detected must be compared with.
struct ScanView {
  Eigen::Vector2d p_base_sensor = Eigen::Vector2d::Zero();
  double yaw_base_sensor = 0.0;
  double start = 0.0;  ///< bearing of beam 0 [rad]
  double step = 0.0;
  /// Cleaned ranges: +inf where nothing came back (free), 0 where the beam tells nothing (the robot itself).
  std::vector<float> ranges;
};

/// What the feature map found in one measurement.
class FeatureObservation final : public Observation {
 public:
  std::vector<Detection> detections;
  ScanView view;           ///< without ranges if the detections did not come from a scan
  double max_range = 0.0;  ///< farthest detection from the base [m]
};

}  // namespace waymark
