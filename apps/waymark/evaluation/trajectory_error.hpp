// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "apps/waymark/evaluation/alignment.hpp"
#include "apps/waymark/evaluation/segment_error.hpp"
#include "apps/waymark/evaluation/trajectory_io.hpp"

namespace waymark::evaluation {

/// Statistics of absolute values.
struct ErrorStatistics {
  double rms = 0.0;
  double mean = 0.0;
  double median = 0.0;
  double max = 0.0;
};

/// Of an even number of values, the mean of the two in the middle. There must be one.
double median_of(std::vector<double> values);

/// Statistics of the values' magnitudes; all zero if there is none.
ErrorStatistics statistics(std::vector<double> values);

/// How an estimate is scored.
struct TrajectoryOptions {
  Alignment align = Alignment::none;
  /// The reference is the position of this point of the robot, base frame [m].
  Eigen::Vector3d lever_arm_m = Eigen::Vector3d::Zero();
  /// The estimate is interpolated over at most this time [s].
  double max_time_gap_s = 1.0;
  /// Relative errors over this length of the reference's path [m], unless `rpe_delta_s` is set.
  double rpe_delta_m = 1.0;
  /// Relative errors over this time [s].
  std::optional<double> rpe_delta_s = std::nullopt;
};

/// Relative pose errors (J. Sturm et al., "A benchmark for the evaluation of RGB-D SLAM systems", IROS 2012, eq. 2-4).
struct RelativeError {
  std::size_t pairs = 0;    ///< pairs of poses compared; 0: the reference is coarser than half the delta
  double mean_delta = 0.0;  ///< mean of the real deltas [m] or [s]
  ErrorStatistics translation_m;
  std::optional<ErrorStatistics>
      rotation_rad;  ///< if both know their orientation; else translations compare in the map frame
};

/// The score of one trajectory.
struct TrajectoryError {
  std::size_t reference_points = 0;
  std::size_t scored = 0;
  std::size_t outside = 0;          ///< reference stamps before the first or after the last estimate
  std::size_t in_gap = 0;           ///< reference stamps where the estimate pauses longer than max_time_gap_s
  double duration_s = 0.0;          ///< from the first to the last scored stamp
  double reference_length_m = 0.0;  ///< path of the scored reference points
  int dimensions = 2;               ///< 2: positions compare in the plane; 3: in space
  Alignment align = Alignment::none;
  Pose T_reference_estimate;     ///< the alignment; identity for none
  ErrorStatistics position_m;    ///< absolute trajectory error after alignment
  ErrorStatistics horizontal_m;  ///< the part in the plane
  bool is_planar = false;        ///< the estimate has one height throughout: that of the reference means nothing
  std::optional<ErrorStatistics> yaw_rad;
  RelativeError relative;
  SegmentErrors segments;  ///< empty without orientations
};

/// What is known of a trajectory at one time.
enum class Lookup { found, outside, in_gap };

/// The pose at `stamp`: positions interpolated linearly, orientations along the shortest arc, over at most
/// `max_time_gap_s`.
Lookup pose_at(const Trajectory& trajectory, Time stamp, double max_time_gap_s, Pose& out);

/// Scores `estimate` at the stamps of `reference`; positions are interpolated linearly, orientations along the shortest
/// arc. Throws Error if there is no common time (with both spans), if a lever arm is asked of an estimate without
/// orientation, if se3 is asked of trajectories without z, or if the points do not determine the alignment.
TrajectoryError score_trajectory(const Trajectory& estimate, const Trajectory& reference,
                                 const TrajectoryOptions& options);

}  // namespace waymark::evaluation
