// SPDX-License-Identifier: Apache-2.0
#include "magnetic_field.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace waymark::imu {

namespace {

Eigen::Vector2d strength_and_dip(const Eigen::Vector3d& m_map) {
  return {m_map.norm(), std::atan2(-m_map.z(), m_map.head<2>().norm())};
}

}  // namespace

double MagneticField::deviation(const AttitudeSettings& settings, const Eigen::Vector2d& field,
                                const Eigen::Vector2d& reference) {
  const double strength = std::abs(field.x() - reference.x()) / (settings.field_strength_limit * reference.x());
  const double dip = std::abs(field.y() - reference.y()) / settings.field_dip_limit;
  return std::max(strength, dip);
}

void MagneticField::adopt(const Eigen::Vector3d& m_map) {
  known_ = true;
  reference_ = strength_and_dip(m_map);
  candidate_ = reference_;
  present_.reset(reference_);
  disturbance_ = 0.0;
  clear_s_ = std::numeric_limits<double>::max();
  candidate_s_ = 0.0;
}

void MagneticField::step(const AttitudeSettings& settings, const Eigen::Vector3d& m_map, double dt, bool turning,
                         bool tilt_known) {
  Eigen::Vector2d field = strength_and_dip(m_map);
  if (!tilt_known) field.y() = reference_.y();
  present_.step(field, dt, settings.field_time_s);
  const Eigen::Vector2d& now = present_.value();
  disturbance_ = deviation(settings, now, reference_);
  const double follow = -std::expm1(-dt / settings.field_reference_time_s);
  if (disturbance_ < 1.0) {
    clear_s_ += dt;
    candidate_s_ = 0.0;
    if (tilt_known && usable(settings)) reference_ += follow * (now - reference_);
    return;
  }
  clear_s_ = 0.0;
  if (!tilt_known) return;
  if (candidate_s_ == 0.0 || deviation(settings, now, candidate_) >= 1.0) {
    candidate_ = now;
    candidate_s_ = dt;
    return;
  }
  candidate_ += follow * (now - candidate_);
  if (turning) candidate_s_ += dt;
  if (candidate_s_ < settings.field_adopt_s) return;
  reference_ = candidate_;
  candidate_s_ = 0.0;
  clear_s_ = settings.field_settle_s;
  disturbance_ = deviation(settings, now, reference_);
}

}  // namespace waymark::imu
