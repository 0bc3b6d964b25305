// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "attitude_settings.hpp"
#include "low_pass.hpp"
#include "waymark/io/archive.hpp"

namespace waymark::imu {

/// Strength and dip of the undisturbed field, and how far the present one is from it. The reference follows slowly
/// while undisturbed; another field that stays steady while the sensor turns becomes the new reference (after D.
/// Laidig, T. Seel, "VQF", Information Fusion 91, 2023, sec. 3.4; own thresholds and weights).
class MagneticField {
 public:
  /// `m_map`: field in the map frame, of which only strength and inclination count [any unit]; `dt` [s]; `turning`: the
  /// sensor turns fast enough to distinguish a field of the place from one that moves along; `tilt_known`: if not, the
  /// dip carries nothing and the reference stays.
  void step(const AttitudeSettings& settings, const Eigen::Vector3d& m_map, double dt, bool turning, bool tilt_known);
  /// Makes this field the reference.
  void adopt(const Eigen::Vector3d& m_map);

  bool known() const { return known_; }
  /// Deviation of strength and dip in units of their limits; 1 and more is disturbed.
  double disturbance() const { return disturbance_; }
  /// Undisturbed for long enough to be used for the heading.
  bool usable(const AttitudeSettings& settings) const { return clear_s_ >= settings.field_settle_s; }

  double strength() const { return reference_.x(); }  ///< of the reference [unit of the magnetometer]
  double dip() const { return reference_.y(); }       ///< of the reference, down positive [rad]

  template <class Archive>
  void serialize(Archive& archive) {
    archive.section("magnetic_field", 1);
    archive(known_, reference_, candidate_, present_, disturbance_, clear_s_, candidate_s_);
  }

 private:
  static double deviation(const AttitudeSettings& settings, const Eigen::Vector2d& field,
                          const Eigen::Vector2d& reference);

  bool known_ = false;
  Eigen::Vector2d reference_ = Eigen::Vector2d::Zero();  // strength, dip
  Eigen::Vector2d candidate_ = Eigen::Vector2d::Zero();
  FirstOrderLowPass<Eigen::Vector2d> present_;
  double disturbance_ = 0.0;
  double clear_s_ = 0.0;      // undisturbed since
  double candidate_s_ = 0.0;  // near the candidate since, while turning
};

}  // namespace waymark::imu
