// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "waymark/base/api.hpp"
#include "waymark/base/time.hpp"

namespace waymark::estimation {

/// A fix of a point of the robot, and where dead reckoning has that point.
struct ReckonedFix {
  Time stamp{};
  Eigen::Vector2d p_map = Eigen::Vector2d::Zero();    ///< as the fix has it, east and north [m]
  Eigen::Vector2d p_local = Eigen::Vector2d::Zero();  ///< by dead reckoning, in the frame in which it began [m]
  double sigma_m = 0.0;                               ///< of the fix per axis; without its slow part
  double slow_sigma_m = 0.0;  ///< of its slowly varying error per axis (first-order Gauss–Markov)
  double slow_tau_s = 0.0;    ///< time constant of that; 0: there is none
  int sensor = 0;             ///< slow errors of two sensors are independent
};

/// Heading of the frame of dead reckoning in the map.
struct HeadingFit {
  double yaw = 0.0;    ///< [rad]
  double sigma = 0.0;  ///< of its posterior on the circle [rad]
};

/// The rotation that maps dead-reckoned points to their fixes, with an unknown translation: the weighted Procrustes
/// problem in the plane, with full covariances (docs/math/start.md). `reckoned`: joint covariance of the points of dead
/// reckoning, 2n × 2n, in their frame. The posterior is taken over the whole circle, so that a heading that the points
/// leave open, or that has two solutions, has a σ that says so. Fixes that fit worse than their σ enlarge it. Nothing
/// if there are fewer than two points, or if a value is not finite.
WAYMARK_API std::optional<HeadingFit> fit_heading(const std::vector<ReckonedFix>& fixes,
                                                  const Eigen::MatrixXd& reckoned);

}  // namespace waymark::estimation
