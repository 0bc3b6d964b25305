// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "waymark/base/time.hpp"
#include "waymark/config/config.hpp"
#include "waymark/math/pose.hpp"

namespace waymark::simulator {

/// The line that the robot shall follow: a polyline through way points in the map, closed or open.
class Course {
 public:
  /// Reads `waypoints_m`, `closed` and `laps`. Throws ConfigError.
  explicit Course(const Config& config);

  /// The same line, driven at most `laps` times.
  Course limited_to(int laps) const;

  double length() const { return lap_length_ * laps_; }  ///< of all laps [m]
  Eigen::Vector2d point(double s) const;                 ///< at arc length s in [0, length()] [m]
  Pose start() const;                                    ///< on the first way point, heading to the second

 private:
  std::vector<Eigen::Vector2d> corners_;  // a closed course repeats the first at the end
  std::vector<double> arc_length_;        // from the first corner to each
  double lap_length_ = 0.0;
  int laps_ = 1;
};

/// How the robot may move.
struct DriveLimits {
  double speed_mps;          ///< cruising speed
  double speed_swing;        ///< share by which it falls and comes back every 20 s
  double acceleration_mps2;  ///< along the course, also when braking
  double turn_rate_radps;    ///< largest |yaw rate|
  double lookahead_m;        ///< of the pure pursuit; at least 2 speed / turn rate
  double slip_m_per_sqrt_s;  ///< density of the white sideways velocity while moving
};

/// What the robot does at one time.
struct Motion {
  double x, y, yaw;    ///< pose of the base in the map [m, m, rad]
  double v_x, v_y, w;  ///< its velocity and yaw rate in its own frame [m/s, m/s, rad/s]

  Pose pose() const { return Pose::planar(x, y, yaw); }
};

/// Velocity in the map of a point of the base. Without the sideways slip: that is white noise, and white noise in
/// velocity has no finite acceleration, nor a Doppler shift.
Eigen::Vector2d velocity(const Motion& motion, const Eigen::Vector3d& p_base);

/// The true motion: constant twist in steps of 5 ms, joined by exact arcs; after the last step the robot stands.
class Trajectory {
 public:
  static constexpr Duration kStep{5'000'000};

  explicit Trajectory(std::vector<Motion> steps) : steps_(std::move(steps)) {}

  /// `time` counts from the start, not negative.
  Motion at(Duration time) const;
  const std::vector<Motion>& steps() const { return steps_; }

 private:
  std::vector<Motion> steps_;  // never empty
};

/// Drives the course by pure pursuit (R. C. Coulter, "Implementation of the pure pursuit path tracking algorithm",
/// 1992), from rest to rest, until its end or until `duration` is over. `seed` is for the slip only.
Trajectory drive(const Course& course, const DriveLimits& limits, Duration duration, std::uint64_t seed);

/// The positions of a drive without slip and without limit in time, about 0.1 m apart: what landmarks must keep clear
/// of.
std::vector<Eigen::Vector2d> nominal_path(const Course& course, const DriveLimits& limits);

}  // namespace waymark::simulator
