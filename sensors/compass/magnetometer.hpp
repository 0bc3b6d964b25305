// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "waymark/config/config.hpp"

namespace waymark::compass {

/// Calibration of a magnetometer: m = A (m_measured − h), with the hard iron h (what moves along with the robot and is
/// a magnet) and the soft iron A (what bends the field).
class Magnetometer {
 public:
  /// Reads `hard_iron_t` and `soft_iron`.
  explicit Magnetometer(const Config& config);

  /// The field in the sensor's frame [T]. Throws DataError if the reading is not finite or nothing is left of it.
  Eigen::Vector3d calibrated(const Eigen::Vector3d& m_measured) const;

 private:
  Eigen::Vector3d hard_iron_;
  Eigen::Matrix3d soft_iron_;
};

}  // namespace waymark::compass
