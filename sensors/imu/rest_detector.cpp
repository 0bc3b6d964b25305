// SPDX-License-Identifier: Apache-2.0
#include "rest_detector.hpp"

namespace waymark::imu {

void RestDetector::step(const AttitudeSettings& settings, const Eigen::Vector3d& w_sensor,
                        const Eigen::Vector3d& f_sensor, double dt) {
  const auto filter = [&](FirstOrderLowPass<Eigen::Vector3d>& low_pass, bool& known, const Eigen::Vector3d& input) {
    if (known) {
      low_pass.step(input, dt, settings.rest_time_s);
    } else {
      low_pass.reset(input);
      known = true;
    }
    return (input - low_pass.value()).norm();
  };
  bool still = filter(rate_, has_rate_, w_sensor) < settings.rest_rate &&
               rate_.value().cwiseAbs().maxCoeff() < settings.bias_limit;
  if (f_sensor.allFinite()) still = filter(force_, has_force_, f_sensor) < settings.rest_acceleration && still;
  still_s_ = still ? still_s_ + dt : 0.0;
}

}  // namespace waymark::imu
