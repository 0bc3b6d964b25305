// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/waymark/calibration/allan.hpp"
#include "waymark/base/time.hpp"
#include "waymark/config/config.hpp"

namespace waymark::calibration {

/// One sample of an IMU, in its own axes.
struct InertialSample {
  Time stamp;
  Eigen::Vector3d rate;   ///< [rad/s]
  Eigen::Vector3d force;  ///< [m/s²]; NaN: there is none
};

/// What an IMU says while the robot stands.
struct Standing {
  std::string sensor;
  double begin_s = 0.0;  ///< since the first measurement of the log
  double duration_s = 0.0;
  double rate_hz = 0.0;
  double given_noise = 0.0;  ///< `gyro_noise_rad_per_sqrt_s` of the YAML
  Eigen::Vector3d bias;      ///< mean rate [rad/s]
  Eigen::Vector3d bias_sigma;
  WhiteNoise noise;            ///< of the rate, r.m.s. of the axes [rad/√s]
  double given_gravity = 0.0;  ///< `gravity_mps2` of the YAML
  double force_norm = 0.0;     ///< of the mean specific force [m/s²]; NaN: there is none
  double force_norm_sigma = 0.0;
  Eigen::Vector3d force_base;        ///< mean specific force in the axes of the base as it is mounted; NaN: none
  std::vector<AllanPoint> gyro[3];   ///< [rad/s]
  std::vector<AllanPoint> force[3];  ///< [m/s²]; empty if there is none
};

/// The longest part of the samples that stands still, of whole seconds: the spread of rate and force within each is
/// that of a robot at rest, and the mean rates are the same. `moving`: stamps at which other sensors measured motion,
/// in order. Nothing if it is shorter than 20 s.
std::optional<Standing> standing_of(const std::vector<InertialSample>& samples, const std::vector<Time>& moving);

/// That of the IMUs of a robot over its log, or its first part; those that never stand are left out. Throws what
/// `Robot::load` and sources throw.
std::vector<Standing> standing_over_log(const std::filesystem::path& yaml,
                                        const std::vector<Config::Override>& overrides, std::optional<double> until_s,
                                        const std::vector<std::string>& imus);

}  // namespace waymark::calibration
