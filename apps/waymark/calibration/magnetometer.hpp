// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/waymark/calibration/iron.hpp"
#include "waymark/config/config.hpp"

namespace waymark::calibration {

/// What a log says of a magnetometer, in the axes of the sensor.
struct Magnetometer {
  std::string sensor;
  bool has_keys = true;  ///< the plugin has `hard_iron_t` and `soft_iron`
  long readings = 0;
  Iron iron;  ///< in the axes of the base
  Eigen::Vector3d given_hard = Eigen::Vector3d::Zero();
  Eigen::Matrix3d given_soft = Eigen::Matrix3d::Identity();
  double given_scatter = 0.0;                      ///< as `Iron::scatter`, with the given values
  Eigen::Vector3d hard = Eigen::Vector3d::Zero();  ///< [T]; upwards as given, where that was not excited
  Eigen::Vector3d hard_sigma = Eigen::Vector3d::Zero();
  Eigen::Matrix3d soft = Eigen::Matrix3d::Identity();

  /// True if the readings go round: what is left between them is less than a right angle, and the centre is known to
  /// 5 % of the strength.
  bool is_determined() const;
};

/// The keys of plugin compass.
inline constexpr const char* kHardIron = "hard_iron_t";
inline constexpr const char* kSoftIron = "soft_iron";

/// Those of a robot over its log, or its first part; those without 50 readings of the field, or whose readings lie on
/// no ellipse, are left out. Throws what `Robot::load` and sources throw.
std::vector<Magnetometer> magnetometers_over_log(const std::filesystem::path& yaml,
                                                 const std::vector<Config::Override>& overrides,
                                                 std::optional<double> until_s,
                                                 const std::vector<std::string>& sensors);

}  // namespace waymark::calibration
