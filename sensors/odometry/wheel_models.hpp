// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "waymark/config/config.hpp"
#include "waymark/interface/measurement.hpp"

namespace waymark::odometry {

/// Planar twist of the base as the wheels give it.
struct WheelTwist {
  double v_x = 0.0;  ///< [m/s]
  double v_y = 0.0;  ///< [m/s]
  double w_z = 0.0;  ///< [rad/s]
  /// The twist is constant for so long from the stamp on; nothing: it is that of the stamp.
  std::optional<double> interval_s = std::nullopt;
};

/// Kinematics: from what the wheels measure to the twist of the base (midpoint of the driven or rear axle).
class WheelModel {
 public:
  virtual ~WheelModel() = default;
  /// Throws DataError if the payload is of another type or cannot be used.
  virtual WheelTwist twist(const Measurement& measurement) const = 0;
  /// True if the rotation is measured through the same wheels as the speed, so that a scale error of the wheels scales
  /// both.
  virtual bool rotation_scales_with_speed() const = 0;
  /// True if the base stands on the ground that it drives on; a ready-made twist can be that of a drone.
  virtual bool has_wheels() const { return false; }
  /// σ of what a usual vehicle of this kind pulls to one side: ω = κ v for wheels that report to go straight [1/m].
  virtual double usual_curvature_sigma() const = 0;
  /// What the noise density of the rotation usually is: a + b · speed + c · rate [rad/√s].
  virtual std::vector<double> usual_yaw_noise() const { return {0.03, 0.03, 0.2}; }

  /// Reads `model` (differential, ackermann, twist, increment) and its geometry. Throws ConfigError.
  static std::shared_ptr<const WheelModel> read(const Config& config);
};

}  // namespace waymark::odometry
