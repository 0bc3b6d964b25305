// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "ego_velocity.hpp"
#include "radar_updates.hpp"
#include "waymark/config/config.hpp"
#include "waymark/interface/nav_state.hpp"

namespace waymark::radar {

/// That the base's origin is the middle of a rear axle, which does not move sideways but for slip.
struct RearAxle {
  double noise = 0.0;            ///< density of the lateral velocity [m/√s]
  double noise_per_speed = 0.0;  ///< the same, per speed [√s]
  double slip = 0.0;             ///< slip angle per lateral acceleration [rad s²/m]
  double slip_sigma = 0.0;       ///< its σ; 0: no state
};

/// The keys of the sensor.
struct RadarSettings {
  ScanSettings scan;
  double error_time_s = 0.0;  ///< how long the errors stay that targets share
  double still_speed_mps = 0.0;
  double mounting_yaw_sigma_rad = 0.0;  ///< 0: no state
  double speed_scale_sigma = 0.0;       ///< 0: no state
  std::optional<RearAxle> rear_axle;

  /// Throws ConfigError.
  static RadarSettings read(const Config& config);
  StateBlock block() const;
  BlockIndex index() const;
};

}  // namespace waymark::radar
