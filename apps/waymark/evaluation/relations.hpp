// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <vector>

#include "apps/waymark/evaluation/trajectory_io.hpp"

namespace waymark::evaluation {

/// How the sensor really moved between two times, checked by hand.
struct Relation {
  Time from;
  Time to;
  Pose T_from_to;
};

/// Reads `t1 t2 x y z roll pitch yaw` [s, m, rad], one relation a line. Throws DataError with file and line.
std::vector<Relation> read_relations(const std::filesystem::path& file);

/// How relations are scored.
struct RelationOptions {
  Pose T_base_sensor;           ///< the relations are between poses of this frame of the robot
  double max_time_gap_s = 1.0;  ///< longest pause of the estimate to interpolate over, without a motion
  double far_apart_s = 60.0;    ///< relations over a longer time are also scored by themselves
};

/// Mean, standard deviation (of the population) and maximum.
struct Spread {
  double mean = 0.0;
  double deviation = 0.0;
  double max = 0.0;
};

/// The errors of some relations; their magnitudes and the squares of these.
struct RelationErrors {
  std::size_t count = 0;
  Spread translation_m;
  Spread translation_squared_m2;
  Spread rotation_rad;
  Spread rotation_squared_rad2;
};

/// The metric of R. Kümmerle et al., "On measuring the accuracy of SLAM algorithms", Autonomous Robots 27(4), 2009: the
/// error of a relation is its inverse times the motion that the estimate shows between its two times.
struct RelationScore {
  std::size_t relations = 0;
  std::size_t uncovered = 0;     ///< the estimate does not cover one of the two poses
  std::size_t poses = 0;         ///< of the relations scored, two each
  std::size_t poses_at_row = 0;  ///< of these: the estimate has a row of that time, to 1 µs
  RelationErrors all;
  RelationErrors far_apart;  ///< over more than `far_apart_s`
};

/// Scores the estimate. A pose between two of its rows is interpolated, over at most `max_time_gap_s`; with `motion`,
/// any trajectory of the same robot without corrections (dead reckoning), it is that motion added to the row before,
/// blended with the same taken back from the row after, by the share of the way. Beyond its first or last row the
/// estimate goes on with `motion` for at most `max_time_gap_s`. Throws Error if no relation is covered, or a trajectory
/// has no orientation.
RelationScore score_relations(const std::vector<Relation>& relations, const Trajectory& estimate,
                              const std::optional<Trajectory>& motion, const RelationOptions& options);

}  // namespace waymark::evaluation
