// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "attitude_settings.hpp"
#include "low_pass.hpp"
#include "waymark/io/archive.hpp"

namespace waymark::imu {

/// Detects from rate and specific force whether the sensor rests: neither strays from its low-pass, and the low-passed
/// rate is no larger than a bias can be (the criterion of D. Laidig, T. Seel, "VQF", Information Fusion 91, 2023).
class RestDetector {
 public:
  /// `w_sensor` [rad/s]; `f_sensor` [m/s²], may be NaN: then the rate alone decides. `dt` [s] since the last sample.
  void step(const AttitudeSettings& settings, const Eigen::Vector3d& w_sensor, const Eigen::Vector3d& f_sensor,
            double dt);
  /// Forgets everything, after a gap.
  void reset() { *this = RestDetector(); }

  bool resting(const AttitudeSettings& settings) const { return still_s_ >= settings.rest_s; }
  /// The low-passed rate [rad/s]; at rest this is the gyro's bias.
  const Eigen::Vector3d& rate() const { return rate_.value(); }

  template <class Archive>
  void serialize(Archive& archive) {
    archive.section("rest_detector", 1);
    archive(rate_, force_, has_rate_, has_force_, still_s_);
  }

 private:
  FirstOrderLowPass<Eigen::Vector3d> rate_;
  FirstOrderLowPass<Eigen::Vector3d> force_;
  bool has_rate_ = false;
  bool has_force_ = false;
  double still_s_ = 0.0;
};

}  // namespace waymark::imu
