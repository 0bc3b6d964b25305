// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <numbers>

namespace waymark::imu {

/// Parameters of the attitude filter. The defaults are those of all results in docs/results/imu.md, for MEMS devices of
/// the usual kind. Angles in rad, times in s, accelerations in m/s². The magnetometer's unit does not matter.
struct AttitudeSettings {
  static constexpr double kDegree = std::numbers::pi / 180.0;

  double gravity_mps2 = 9.81;  ///< local gravity, as the accelerometer should show it

  // Start-up levelling: specific force and field are averaged in the frame that the gyro carries along.
  double levelling_s = 1.0;                         ///< length of the average
  double levelling_tilt_sigma = 2.0 * kDegree;      ///< of roll and pitch after it
  double levelling_heading_sigma = 10.0 * kDegree;  ///< of the heading after it, with a magnetometer
  double declination = 0.0;                         ///< of the field, east positive

  // Gyro. Its angle error grows with (gyro_noise + gyro_noise_per_rate·|ω|)² per second.
  double gyro_noise = 0.05 * kDegree;  ///< [rad/√s]
  double gyro_noise_per_rate = 1e-3;   ///< [√s]: scale and axis errors
  double bias_sigma = 0.5 * kDegree;   ///< of the gyro bias at the start, per axis [rad/s]
  double bias_walk = 0.02 * kDegree;   ///< random walk of the bias [rad/s/√s]
  double bias_limit = 4.0 * kDegree;   ///< the bias of no axis is larger [rad/s]
  double max_gap_s = 0.5;              ///< a longer gap without gyro: level again

  // An axis at the end of its range: a rate above `saturation_rate` that stays within `saturation_spread` for
  // `saturation_s`. The attitude about it gets uncertain by `saturation_noise`.
  double saturation_rate = 4.0;     ///< [rad/s]
  double saturation_spread = 0.01;  ///< relative
  double saturation_s = 0.05;
  double saturation_noise = 2.0;  ///< [rad/√s]

  // Accelerometer: the low-passed specific force points up, with
  // σ² = tilt_sigma² + (tilt_per_motion·a/g)² + (tilt_per_magnitude·Δ/g)²; a is the r.m.s. of what the low-pass takes
  // out, Δ the deviation of the low-passed magnitude from gravity.
  double accelerometer_time_s = 2.0;  ///< time constant of the low-pass
  double tilt_sigma = 0.3 * kDegree;
  double tilt_per_motion = 0.01;
  double tilt_per_magnitude = 0.5;
  double acceleration_time_s = 1.5;  ///< how long they stay: R is multiplied by max(1, 2·this/Δt)

  // Magnetometer: heading with σ = heading_sigma·(1 + heading_per_disturbance·d²); d = 1 is the limit of disturbance.
  double heading_sigma = 4.0 * kDegree;
  double heading_time_s = 3.0;  ///< how long its errors stay: R is multiplied by max(1, 2·this/Δt)
  double heading_per_disturbance = 3.0;
  double unknown_tilt = 10.0 * kDegree;      ///< σ of roll or pitch from which the field corrects them, too
  double field_time_s = 0.05;                ///< low-pass of strength and dip
  double field_reference_time_s = 20.0;      ///< how fast the reference follows an undisturbed field
  double field_strength_limit = 0.1;         ///< deviation that counts as disturbed, relative
  double field_dip_limit = 10.0 * kDegree;   ///< the same for the dip
  double field_settle_s = 0.5;               ///< undisturbed for so long before the heading is used again
  double field_adopt_s = 20.0;               ///< a field steady for so long, while turning, is the new reference
  double field_adopt_rate = 20.0 * kDegree;  ///< what counts as turning [rad/s]

  // Rest: rate and specific force near their low-pass and the rate small, for `rest_s`. The low-passed rate is then the
  // bias.
  double rest_s = 1.5;
  double rest_time_s = 0.5;                 ///< time constant of those low-passes
  double rest_rate = 2.0 * kDegree;         ///< largest deviation of the rate [rad/s]
  double rest_acceleration = 0.5;           ///< largest deviation of the specific force [m/s²]
  double rest_bias_sigma = 0.03 * kDegree;  ///< of the low-passed rate as bias [rad/s]
  double rest_surprise = 0.1 * kDegree;     ///< a rate 3σ off the bias is a slow turn; this σ adds to its own [rad/s]
  double rest_insist_s = 10.0;              ///< unless it lasts so long
};

}  // namespace waymark::imu
