// SPDX-License-Identifier: Apache-2.0
#include "device_orientation.hpp"

#include <algorithm>
#include <cmath>

#include "attitude_settings.hpp"
#include "waymark/base/error.hpp"

namespace waymark::imu {

DeviceOrientation::DeviceOrientation(const Config& config)
    : tilt_sigma_(
          AttitudeSettings::kDegree *
          config.number_in({"device_tilt_sigma_deg", "°", "for `orientation: device`: noise of its roll and pitch"},
                           1e-3, 90.0, 1.0)),
      heading_sigma_(AttitudeSettings::kDegree * config.number_in({"device_heading_sigma_deg", "°",
                                                                   "for `orientation: device`: noise of its heading"},
                                                                  1e-3, 180.0, 5.0)),
      time_(config.non_negative(
          {"device_time_s", "s",
           "for `orientation: device`: how long its errors stay; R is multiplied by max(1, 2 · this / interval)"},
          2.0)) {}

Eigen::Quaterniond DeviceOrientation::of(const ImuSample& sample) {
  constexpr double kRounded = 0.05;  // a log may give it with two decimals
  const double norm = sample.q_enu_sensor.norm();
  if (!std::isfinite(norm)) throw DataError("the sample has no orientation made by the device");
  if (std::abs(norm - 1.0) > kRounded) throw DataError("the device's orientation is not a unit quaternion");
  return sample.q_enu_sensor.normalized();
}

Eigen::Vector3d DeviceOrientation::variance(double dt) const {
  const double repeated = std::max(1.0, 2.0 * time_ / dt);
  return repeated *
         Eigen::Vector3d(tilt_sigma_ * tilt_sigma_, tilt_sigma_ * tilt_sigma_, heading_sigma_ * heading_sigma_);
}

}  // namespace waymark::imu
