// SPDX-License-Identifier: Apache-2.0
#include "saturation.hpp"

#include <algorithm>
#include <cmath>

namespace waymark::imu {

Eigen::Vector3d SaturationDetector::step(const AttitudeSettings& settings, const Eigen::Vector3d& w_sensor, double dt) {
  largest_ = std::max(largest_, w_sensor.cwiseAbs().maxCoeff());
  Eigen::Vector3d saturated = Eigen::Vector3d::Zero();
  for (Eigen::Index i = 0; i < 3; ++i) {
    const double rate = std::abs(w_sensor(i));
    const bool large = rate > settings.saturation_rate && rate > 0.97 * largest_;
    if (!large || std::abs(w_sensor(i) - level_(i)) > settings.saturation_spread * rate) {
      level_(i) = w_sensor(i);
      since_s_(i) = 0.0;
      continue;
    }
    const bool known = since_s_(i) >= settings.saturation_s;
    since_s_(i) += dt;
    if (since_s_(i) >= settings.saturation_s) saturated(i) = known ? dt : since_s_(i);
  }
  return saturated;
}

}  // namespace waymark::imu
