// SPDX-License-Identifier: Apache-2.0
#include "magnetometer.hpp"

#include <Eigen/LU>
#include <cmath>

#include "waymark/base/error.hpp"

namespace waymark::compass {

Magnetometer::Magnetometer(const Config& config) {
  const auto h = config.numbers({"hard_iron_t", "T", "field: the robot's own magnets in the sensor's axes, subtracted"},
                                3, {0.0, 0.0, 0.0});
  const auto a = config.numbers(
      {"soft_iron", "", "field: 3 × 3 matrix by rows, applied after the subtraction of `hard_iron_t`", "identity"}, 9,
      {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0});
  hard_iron_ = {h[0], h[1], h[2]};
  soft_iron_ << a[0], a[1], a[2], a[3], a[4], a[5], a[6], a[7], a[8];
  if (!(std::abs(soft_iron_.determinant()) > 1e-6)) config.fail("soft_iron", "the matrix is singular");
  if (soft_iron_.determinant() < 0.0) config.fail("soft_iron", "the matrix mirrors: a left-handed sensor?");
}

Eigen::Vector3d Magnetometer::calibrated(const Eigen::Vector3d& m_measured) const {
  if (!m_measured.allFinite()) throw DataError("there is no magnetic field in the measurement");
  Eigen::Vector3d m = soft_iron_ * (m_measured - hard_iron_);
  if (!(m.norm() > 0.0)) throw DataError("the magnetic field is zero");
  return m;
}

}  // namespace waymark::compass
