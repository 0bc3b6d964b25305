// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "waymark/config/config.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::imu {

/// The attitude that the device makes of its axes by itself (`orientation: device`), with noise of its own: nothing is
/// known of the filter inside.
class DeviceOrientation {
 public:
  /// Reads `device_tilt_sigma_deg`, `device_heading_sigma_deg`, `device_time_s`.
  explicit DeviceOrientation(const Config& config);

  /// R_enu_sensor, of magnetic or true north as the device has it. Throws DataError if there is none in the sample.
  static Eigen::Quaterniond of(const ImuSample& sample);

  double tilt_sigma() const { return tilt_sigma_; }        ///< of roll and pitch [rad]
  double heading_sigma() const { return heading_sigma_; }  ///< [rad]
  /// Variance of (roll, pitch, heading) of a sample `dt` after the one before: its errors stay for `device_time_s`.
  Eigen::Vector3d variance(double dt) const;

 private:
  double tilt_sigma_;
  double heading_sigma_;
  double time_;
};

}  // namespace waymark::imu
