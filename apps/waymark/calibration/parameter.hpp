// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

#include "waymark/config/config.hpp"

namespace waymark::calibration {

/// A number of the YAML that is estimated from a log: geometry, a delay, a scale, or a noise level.
struct Parameter {
  /// What a change means.
  enum class Kind {
    value,   ///< the number itself, or one element of a list
    factor,  ///< a factor on the number; its logarithm is estimated
    noise    ///< a factor on a level of noise, a number or some elements of a list; its logarithm is estimated
  };

  std::string sensor;
  std::string key;   ///< below the sensor: "track_m", "base_T_sensor.yaw_deg", "base_p_antenna_m"
  int element = -1;  ///< of a list, the first one; -1: a number, or all of a list
  int elements = 1;  ///< so many of the list
  std::string unit;
  Kind kind = Kind::value;
  double prior_sigma = 0.0;  ///< how far the given value may be off, before the log is read; the same

  /// "wheels.track_m", "gps.base_p_antenna_m[0]", "wheels.yaw_noise_rad_per_sqrt_s[0..1]".
  std::string name() const;
};

/// A number of one sensor's block, or what it is where the YAML leaves it out. Throws ConfigError, and Error if there
/// is no such sensor.
double number_of(const Config& yaml, const std::string& sensor, const char* key, double fallback);

/// The values of some numbers and lists of one YAML, by their path in it.
class Values {
 public:
  /// Reads the keys of the parameters, with defaults where the YAML leaves them out. Throws ConfigError.
  Values(const Config& yaml, const std::vector<Parameter>& parameters);

  /// The values with parameter i changed by delta(i), as overrides of the YAML.
  std::vector<Config::Override> changed(const Eigen::VectorXd& delta) const;
  /// What a level's factor scales, as the YAML gives it.
  std::vector<double> given(std::size_t i) const;
  /// The value of parameter i, changed; of a level that of its first element that is not zero.
  double value(std::size_t i, double delta) const;

 private:
  std::vector<Parameter> parameters_;
  std::map<std::string, std::vector<double>> numbers_;  // by path
  std::map<std::string, bool> is_list_;
};

/// What of a robot can be estimated, after the plugins of its sensors; and overrides with which the filter follows the
/// path in spite of wrong parameters (open gates), for a first guess.
struct Plan {
  std::vector<Parameter> parameters;
  /// Levels of noise that weigh the equations and are not asked for.
  std::vector<Parameter> others;
  std::vector<Config::Override> overrides;
  /// IMUs whose noise is read from a standing stretch.
  std::vector<std::string> imus;
  /// Of these, those whose `gravity_mps2` is read from it.
  std::vector<std::string> accelerometers;
  /// Sensors whose hard and soft iron is fitted, if they deliver a magnetic field.
  std::vector<std::string> magnetometers;
};

/// What a standing stretch says of an IMU: keys of the plugin imu.
inline constexpr const char* kGyroNoise = "gyro_noise_rad_per_sqrt_s";
inline constexpr const char* kGravity = "gravity_mps2";

/// The plan for a YAML. `only`: names of parameters, or beginnings ("gps", "wheels.track_m"); empty: all. Throws Error
/// for a name that fits nothing.
Plan plan_for(const Config& yaml, const std::vector<std::string>& only);

}  // namespace waymark::calibration
