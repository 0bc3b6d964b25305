// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "map_modules/octomap_grid/octomap_grid_settings.hpp"
#include "map_modules/shared/scan_matching/scan_points.hpp"
#include "waymark/interface/map_module.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::octomap_grid {

/// One scan or cloud in space.
struct CloudObservation final : Observation, scan_matching::ScanPoints<3> {
  CloudObservation() = default;
  explicit CloudObservation(scan_matching::ScanPoints<3> points) : ScanPoints(std::move(points)) {}

  std::vector<Eigen::Vector3f> matched;  ///< those of the end points that are matched
  bool is_dense = false;                 ///< many points in one voxel: one beam for each voxel is enough
};

/// The points of a scan that are used; matched are those at `match.height_m`. Throws DataError if there is none, and
/// nothing that is free either.
CloudObservation observe(const LaserScan& scan, const Pose& T_base_sensor, const MotionWindow& motion,
                         const OctomapGridSettings& settings);

/// The points of a cloud that are used, in the base frame at the cloud's stamp: motion-compensated, if the cloud has a
/// time for each. Matched are one in a voxel, of those every n-th, and of those the ones at
/// `match.height_m`. Throws DataError if there is none, or if there are not as many times as points.
CloudObservation observe(const PointCloud& cloud, const Pose& T_base_sensor, const MotionWindow& motion,
                         const OctomapGridSettings& settings);

}  // namespace waymark::octomap_grid
