// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "comparison.hpp"
#include "dead_reckoning.hpp"

namespace waymark::host::diagnosis {

/// How a scanner stands on the robot, from its own motions and the way that another sensor measured: hand-eye
/// calibration in the plane (docs/doctor.md).
struct MountingFit {
  bool is_known = false;
  double scale = 0.0;  ///< its lengths by those of the way
  double scale_sigma = 0.0;
  double median_scale = 0.0;  ///< of the single motions
  double median_sigma = 0.0;  ///< from their quartiles
  double angle = 0.0;  ///< from the base's x axis, as the YAML has it, to where it moves when the robot drives [rad]
  double angle_sigma = 0.0;
  Eigen::Vector2d lever{0.0, 0.0};  ///< of the scanner in the base frame, of a robot that moves along its x axis [m]
  Eigen::Vector2d lever_sigma{0.0, 0.0};
  double kept = 0.0;  ///< share of the motions that fit
};
/// `late`: by so much the scanner's stamps are behind those of the way [s].
MountingFit fit_mounting(const std::vector<ScanStep>& steps, const Track& way, double late);

/// Where an antenna stands and how late its fixes are, from fixes and the dead reckoning of others.
struct AntennaFit {
  bool is_known = false;
  Eigen::Vector2d lever{0.0, 0.0};  ///< in the base frame [m]
  Eigen::Vector2d lever_sigma{0.0, 0.0};
  Lag lag;                ///< of the fixes
  double residual = 0.0;  ///< [m], of a step from fix to fix
  /// Clearly better than the lag with the lever arm of the YAML is this lever arm without a lag.
  bool is_lever_likelier = false;
  /// Clearly better than no lag is this one.
  bool is_lag_likelier = false;
};
/// `yaw` and `way` must agree with the other sensors; `per_way` is the yaw's turn per way that is to be taken out, and
/// `per_s` its bias.
/// `lever`: where the YAML has the antenna. `late`: by so much the stamps of the way are behind those of the yaw [s],
/// against which the lag of the fixes counts.
AntennaFit fit_antenna(const std::vector<Fix>& fixes, const Eigen::Vector2d& lever, const Track& yaw, const Way& way,
                       double per_way, double per_s, double late);

}  // namespace waymark::host::diagnosis
