// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/LU>

#include "waymark/interface/map_module.hpp"

/// What the camera detected, the same for all particles.
struct Seen : waymark::Observation {
  Eigen::Vector2d p_base;
};

/// Where the dock lies if the base is at `T_map_base`, and how that changes with (x, y, yaw).
struct DockView {
  DockView(const waymark::Pose& T_map_base, const waymark::Observation& seen) {
    const Eigen::Vector2d d = Eigen::Rotation2Dd(T_map_base.yaw()) * static_cast<const Seen&>(seen).p_base;
    p_map = T_map_base.p.head<2>() + d;
    G << 1.0, 0.0, -d.y(), 0.0, 1.0, d.x();
  }
  Eigen::Vector2d p_map;
  Eigen::Matrix<double, 2, 3> G;
};
