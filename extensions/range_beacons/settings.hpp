// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "waymark/interface/particle_map.hpp"

namespace waymark::range_beacons {

/// Figures of the map that do not change during a run.
struct Settings {
  Eigen::Vector3d p_base_antenna = Eigen::Vector3d::Zero();  ///< [m]
  double sigma_m = 0.0;                                      ///< noise of a range
  double scale = 1.0;                                        ///< first value of the scale of all ranges
  double scale_sigma = 0.0;                                  ///< its σ; 0: it is known
  double outlier_share = 0.0;                                ///< of ranges that say nothing
  double range_max_m = 0.0;                                  ///< an outlier is anywhere up to it
  double settled = 0.0;  ///< σ of a place per distance below which one Gaussian is enough
};

/// The ranges of one burst.
struct RangeSet : Observation {
  struct One {
    int beacon;
    double range_m;
    double sigma_m;
  };
  std::vector<One> ranges;
};

/// The antenna in the plane for a pose of the base, and how it changes with (x, y, yaw).
struct Antenna {
  Antenna(const Pose& T_map_base, const Eigen::Vector3d& p_base_antenna) {
    const Eigen::Vector2d arm = (T_map_base.q * p_base_antenna).head<2>();
    p = T_map_base.p.head<2>() + arm;
    by_pose << 1.0, 0.0, -arm.y(), 0.0, 1.0, arm.x();
  }
  Eigen::Vector2d p;
  Eigen::Matrix<double, 2, 3> by_pose;
};

}  // namespace waymark::range_beacons
