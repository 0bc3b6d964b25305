// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>

#include "attitude_settings.hpp"
#include "waymark/io/archive.hpp"

namespace waymark::imu {

/// Detects when a gyro axis is at the end of its range: a large reading that stays the same, near the largest ever
/// seen. The true rate is then larger by an unknown amount.
class SaturationDetector {
 public:
  /// Takes the measured rate [rad/s], `dt` [s] after the last. Returns for how long each axis has newly been found
  /// saturated [s]: zero if it is not, the whole plateau when it is found out, then `dt`.
  Eigen::Vector3d step(const AttitudeSettings& settings, const Eigen::Vector3d& w_sensor, double dt);

  template <class Archive>
  void serialize(Archive& archive) {
    archive.section("saturation_detector", 1);
    archive(largest_, level_, since_s_);
  }

 private:
  double largest_ = 0.0;                               // of all axes [rad/s]
  Eigen::Vector3d level_ = Eigen::Vector3d::Zero();    // reading at the beginning of the present plateau [rad/s]
  Eigen::Vector3d since_s_ = Eigen::Vector3d::Zero();  // length of the plateau
};

}  // namespace waymark::imu
