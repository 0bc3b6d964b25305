// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "ground.hpp"
#include "waymark/base/time.hpp"
#include "waymark/config/config.hpp"
#include "waymark/math/pose.hpp"

namespace waymark::simulator {

/// The line that the robot shall follow: a polyline through way points in the map, closed or open.
class Course {
 public:
  /// Reads `waypoints_m`, `closed`, `laps` and `start_height_m`. Throws ConfigError.
  explicit Course(const Config& config);

  /// The same line, driven at most `laps` times.
  Course limited_to(int laps) const;

  double length() const { return lap_length_ * laps_; }  ///< of all laps [m]
  Eigen::Vector2d point(double s) const;                 ///< at arc length s in [0, length()] [m]
  Pose start() const;                                    ///< on the first way point, heading to the second
  double start_height_m() const { return start_height_m_; }

 private:
  std::vector<Eigen::Vector2d> corners_;  // a closed course repeats the first at the end
  std::vector<double> arc_length_;        // from the first corner to each
  double lap_length_ = 0.0;
  int laps_ = 1;
  double start_height_m_ = 0.0;
};

/// How the robot may move.
struct DriveLimits {
  double speed_mps;          ///< cruising speed
  double speed_swing;        ///< share by which it falls and comes back every 20 s
  double acceleration_mps2;  ///< along the course, also when braking
  double turn_rate_radps;    ///< largest |yaw rate|
  double lookahead_m;        ///< of the pure pursuit; at least 2 speed / turn rate
  double slip_m_per_sqrt_s;  ///< density of the white sideways velocity while moving
  double start_s;            ///< until when the robot stands on the first way point
};

/// What the robot does at one time: its motion as it is seen from above, and the surface that it stands on. The base's
/// z axis is that surface's normal, its x axis lies in the surface and has the yaw of the plan.
struct Motion {
  double x, y, yaw;    ///< pose of the base in the plan [m, m, rad]
  double v_x, v_y, w;  ///< velocity and yaw rate in the plan, in the axes of the yaw [m/s, m/s, rad/s]
  bool is_level = true;
  Slope slope{};  ///< under the base; zero where it is level

  Pose pose() const;
  Eigen::Vector3d v_base() const;  ///< velocity in the base's frame [m/s]; along z there is none
  Eigen::Vector3d w_base() const;  ///< angular rate in the base's frame [rad/s]
  Eigen::Vector3d w_map() const;   ///< the same in the map's frame
};

/// Velocity in the map of a point of the base. Without the sideways slip: that is white noise, and white noise in
/// velocity has no finite acceleration, nor a Doppler shift.
Eigen::Vector3d velocity(const Motion& motion, const Eigen::Vector3d& p_base);

/// The true motion: constant twist of the plan in steps of 5 ms, joined by exact arcs; after the last step the robot
/// stands.
class Trajectory {
 public:
  static constexpr Duration kStep{5'000'000};

  explicit Trajectory(std::vector<Motion> steps) : steps_(std::move(steps)) {}

  /// The same drive on a ground that is not level. The height goes on from `start_height_m`, so that where decks lie
  /// above each other the robot is on the one that it came by. Throws std::domain_error that names the place where it
  /// drives over an edge or into the side of a deck.
  Trajectory on(std::shared_ptr<const Ground> ground, double start_height_m) const;

  /// `time` counts from the start, not negative.
  Motion at(Duration time) const;
  const std::vector<Motion>& steps() const { return steps_; }

 private:
  std::vector<Motion> steps_;             // never empty
  std::shared_ptr<const Ground> ground_;  // null: level
  std::vector<int> decks_;                // that the robot is on, of each step
};

/// Drives the course by pure pursuit (R. C. Coulter, "Implementation of the pure pursuit path tracking algorithm",
/// 1992), from rest to rest, until its end or until `duration` is over. `seed` is for the slip only.
Trajectory drive(const Course& course, const DriveLimits& limits, Duration duration, std::uint64_t seed);

/// The positions of a drive without slip and without limit in time, about 0.1 m apart: what landmarks must keep clear
/// of. `ground` as in `Trajectory::on`, null if it is level.
std::vector<Eigen::Vector3d> nominal_path(const Course& course, const DriveLimits& limits,
                                          const std::shared_ptr<const Ground>& ground);

}  // namespace waymark::simulator
