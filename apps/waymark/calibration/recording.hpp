// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "waymark/base/time.hpp"
#include "waymark/config/config.hpp"

namespace waymark::calibration {

/// A rate as a function of time, by its integral: trapezoids between samples, means of intervals as they are.
class Integral {
 public:
  /// A sample at t [s], in order; `interval_s` > 0: the mean over so long from t on.
  void add(double t, double rate, double interval_s);
  /// Mean rate from a to b; nothing where there are no samples, or a gap of more than half a second.
  std::optional<double> mean(double a, double b) const;
  const std::vector<double>& times() const { return t_; }

 private:
  double at(double t, std::size_t interval) const;
  std::vector<double> t_;
  std::vector<double> sum_;
  std::vector<bool> is_gap_;  // before the time of the same index
  double last_rate_ = 0.0;
};

/// Forward and lateral speed [m/s] and yaw rate [rad/s] that a sensor of motion gives, with the YAML's calibration.
struct Wheels {
  std::string sensor;
  Integral speed;
  Integral lateral;
  Integral rate;
  bool yaw_scales_with_speed = false;
};

/// Yaw rate of a gyro [rad/s].
struct Gyro {
  std::string sensor;
  Integral rate;
};

/// Positions of one point of the robot.
struct Positions {
  std::string sensor;
  Eigen::Vector2d lever{0.0, 0.0};  ///< of the point, in the base frame [m]
  double slow_tau_s = 0.0;          ///< of a slowly varying error; 0: there is none
  double slow_sigma = 0.0;          ///< [m]
  struct Fix {
    double t;
    Eigen::Vector2d p;
    double sigma;  ///< per axis, without the slow part [m]
  };
  std::vector<Fix> fixes;
};

/// Headings of the base, or magnetic fields, of which the heading follows.
struct Headings {
  std::string sensor;
  struct One {
    double t;
    double yaw;    ///< counter-clockwise from east [rad]
    double sigma;  ///< [rad]
  };
  std::vector<One> headings;
};

/// Motions of a scanner between two scans, in the axes of the base as it is mounted by the YAML.
struct Scanner {
  std::string sensor;
  Eigen::Vector2d lever{0.0, 0.0};  ///< [m]
  struct Motion {
    double from;
    double to;
    Eigen::Vector3d moved;  ///< x, y [m] in the axes at `from`, yaw [rad]
    Eigen::Matrix3d covariance;
  };
  std::vector<Motion> motions;
};

/// The pose of the base in the map: x, y [m] and yaw [rad], which grows over ±π.
struct PathPoint {
  double t;
  Eigen::Vector3d pose;
};

/// What a log says about the robot's motion: of every sensor what it measures by itself (`Sensor::observed_motion`),
/// stamps less their `delay_s`, in seconds from the log's first arrival on; and the filter's path as a first guess.
struct Recording {
  std::vector<Wheels> wheels;
  std::vector<Gyro> gyros;
  std::vector<Positions> positions;
  std::vector<Headings> headings;
  std::vector<Scanner> scanners;
  std::vector<PathPoint> path;
};

/// Reads the log of a YAML, or its first part, twice: through the filter for the path, and by itself. What the YAML
/// holds out of the filter is left out. Throws what `Robot::load` and sources
/// throw, and Error if the log has no motion sensor or the filter never starts.
Recording read_recording(const std::filesystem::path& yaml, const std::vector<Config::Override>& overrides,
                         std::optional<double> until_s);

}  // namespace waymark::calibration
