// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <string_view>

#include "attitude_filter.hpp"

namespace waymark::imu {

std::optional<std::string> mounting_fault(const Eigen::Vector3d& f_sensor, const Eigen::Quaterniond& q_base_sensor,
                                          double limit) {
  const Eigen::Vector3d up_base = q_base_sensor * f_sensor;
  if (std::atan2(up_base.head<2>().norm(), up_base.z()) <= limit) return std::nullopt;
  static constexpr std::array<std::string_view, 3> kAxes{"x", "y", "z"};
  Eigen::Index axis = 0;
  f_sensor.cwiseAbs().maxCoeff(&axis);
  // At rest the specific force points up, gravity down.
  const std::string_view sign = f_sensor(axis) > 0.0 ? "-" : "+";
  return "gravity points along " + std::string(sign) + std::string(kAxes[static_cast<std::size_t>(axis)]) +
         " of the sensor: check the mounting";
}

}  // namespace waymark::imu
