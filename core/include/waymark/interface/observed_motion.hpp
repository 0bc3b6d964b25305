// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <limits>

namespace waymark {

/// What one measurement by itself contains about the robot's motion, with the sensor's mounting and calibration
/// applied and without any filter. The host compares these of all sensors with each other to find the one that is
/// configured wrongly (docs/doctor.md). A sensor sets what it measures; NaN is "not measured".
struct ObservedMotion {
  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

  double speed_mps = kUnknown;       ///< of the base, forwards
  double yaw_rate_radps = kUnknown;  ///< about the base's z axis, counter-clockwise
  double interval_s = 0.0;           ///< speed and rate are means over so long from the stamp on; 0: those of the stamp
  double yaw_rad = kUnknown;         ///< heading of the base, counter-clockwise from east

  Eigen::Vector3d p_map_point{kUnknown, kUnknown, kUnknown};  ///< position of a point of the robot [m]
  Eigen::Vector3d p_base_point = Eigen::Vector3d::Zero();     ///< that point in the base frame (the lever arm) [m]
  double ground_speed_mps = kUnknown;  ///< of that point over ground, where it is measured by itself (Doppler)
  double course_rad = kUnknown;        ///< direction of that velocity, counter-clockwise from east

  Eigen::Vector3d f_base{kUnknown, kUnknown, kUnknown};  ///< specific force, in the axes of the base [m/s²]
  Eigen::Vector3d m_base{kUnknown, kUnknown, kUnknown};  ///< magnetic field, in the axes of the base [T]

  double speed_scale_sigma = 0.02;     ///< σ of the speed's scale error that is usual and is no mistake
  double yaw_scale_sigma = 0.02;       ///< the same of the yaw rate
  double curvature_sigma_per_m = 0.0;  ///< the same of a yaw per way that is measured and not driven [rad/m]
  bool yaw_scales_with_speed = false;  ///< one scale error (the wheels') makes both wrong

  double height_m = kUnknown;             ///< of the base in the map, by a sensor that measures nothing else
  double height_offset_sigma_m = 0.0;     ///< σ of an offset that is estimated, or of its wander; 0: none
  double yaw_error_sigma_rad = kUnknown;  ///< σ of the constant error of `yaw_rad` that is usual and is no mistake
  double lateral_speed_mps = kUnknown;    ///< of the base, to its left; beside `speed_mps`
  double position_sigma_m = kUnknown;     ///< σ of `p_map_point` per axis of the plane, as the sensor takes it
  /// σ of a constant error of `yaw_rate_radps` that the sensor's filter estimates.
  double yaw_rate_bias_sigma_radps = kUnknown;
  Eigen::Vector3d w_base{kUnknown, kUnknown, kUnknown};  ///< angular rate, in the axes of the base [rad/s]
};

}  // namespace waymark
