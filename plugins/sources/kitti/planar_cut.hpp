// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <numbers>
#include <span>

#include "waymark/config/config.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/math/pose.hpp"

namespace waymark::kitti {

inline constexpr double kDegree = std::numbers::pi / 180.0;  ///< [rad]

/// Turns a cloud into what a planar scanner would see: of the points between two heights of the base frame, the nearest
/// one in each bin of bearing. Ranges are horizontal, bearings level: the scanner's roll and pitch are taken out.
class PlanarCut {
 public:
  /// Throws ConfigError.
  PlanarCut(const Config& config, const Pose& T_base_sensor);

  struct Result {
    std::shared_ptr<LaserScan> scan;
    std::size_t not_finite = 0;  ///< points that were left out
  };
  /// `points` are x, y, z [m] in the sensor's frame and reflectance, one after the other. A bin without a point shows
  /// `no_return_m()` and the reflectance 0.
  Result operator()(std::span<const float> points) const;

  double no_return_m() const { return range_max_ + 1.0; }

 private:
  double height_low_;
  double height_high_;
  double start_;
  double step_;
  int beams_;
  double range_min_;
  double range_max_;
  Eigen::Matrix3d R_level_sensor_;  // a frame at the sensor, upright as the base is, that looks where the sensor does
  double sensor_height_;
};

}  // namespace waymark::kitti
