// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "octomap_grid_settings.hpp"
#include "waymark/interface/map_module.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::octo {

/// One scan or cloud in the base frame, the same for all particles.
struct CloudObservation final : Observation {
  Eigen::Vector3d p_base_sensor = Eigen::Vector3d::Zero();  ///< where all beams begin [m]
  std::vector<Eigen::Vector3f> hits;                        ///< end points [m]
  std::vector<Eigen::Vector3f> clear_to;                    ///< of beams without return: free up to there [m]
  std::vector<Eigen::Vector3f> matched;                     ///< those of the end points that are matched
  bool is_dense = false;  ///< many points in one voxel: one beam for each voxel is enough
  double reach = 0.0;     ///< of the points and the sensor from the base's origin, at most [m]
};

/// The points of a scan that are used; matched are those at `match.height_m`. Throws DataError if there is none, and
/// nothing that is free either.
CloudObservation observe(const LaserScan& scan, const Pose& T_base_sensor, const MotionWindow& motion,
                         const OctomapGridSettings& settings);

/// The points of a cloud that are used, moved to where they were seen from the base at the cloud's stamp, if the cloud
/// tells when each was measured. Matched are one in a voxel, of those every n-th, and of those the ones at
/// `match.height_m`. Throws DataError if there is none, or if there are not as many times as points.
CloudObservation observe(const PointCloud& cloud, const Pose& T_base_sensor, const MotionWindow& motion,
                         const OctomapGridSettings& settings);

}  // namespace waymark::octo
