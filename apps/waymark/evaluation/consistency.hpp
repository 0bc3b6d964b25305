// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <optional>
#include <vector>

#include "apps/waymark/evaluation/trajectory_error.hpp"

namespace waymark::evaluation {

/// The covariance that an estimate gives for its pose, at one time.
struct PoseCovariance {
  Time stamp;
  Eigen::Matrix3d P;  ///< of (x [m], y [m], yaw [rad]) in the map frame
  /// Of all six, of a run of spatial motion: x, y, z [m], and the rotation about the map's axes [rad].
  std::optional<SpatialMatrix> P_spatial = std::nullopt;
};

/// The normalised estimation error squared of (x, y, yaw), eᵀ P⁻¹ e: 3 on the average and 2.4 at the median if the
/// covariances are right (Bar-Shalom, Li, Kirubarajan, 2001, §5.4). Of (x, y) alone if the reference has no
/// orientation: 2 and 1.4.
struct Consistency {
  int dimensions = 3;  ///< 3, 2 or 6: degrees of freedom of one NEES
  std::size_t scored = 0;
  ErrorStatistics nees;
  double share_within_95 = 0.0;  ///< share of NEES below the 95 % quantile of χ² with so many degrees of freedom
  /// Two-sided 95 % bounds of that χ², for one time: 2.5 % should lie below, 2.5 % above. Below
  /// them the covariance is too large, above them too small.
  double low_95 = 0.0;
  double high_95 = 0.0;
  double share_below = 0.0;
  double share_above = 0.0;
  /// The same for the mean, if the scored times were independent. Those of one run are not: the error of a pose lives
  /// on, so the mean of one honest run leaves these bounds easily.
  double mean_low_95 = 0.0;
  double mean_high_95 = 0.0;
  std::array<double, 4> mean_by_quarter{};  ///< of the scored times: does the filter grow too sure?
  /// Of x, y and yaw, where they are scored: median σ by RMS error. Much above 1 an NEES is bought by inflation.
  std::array<std::optional<double>, 3> sigma_by_rms = {};
};

/// Of at least one NEES of so many degrees of freedom, in the order of time.
Consistency summarize_nees(std::vector<double> nees, int dimensions);

/// Reads covariance.csv of the tum sink: t_s,xx,xy,xyaw,yy,yyaw,yawyaw, and fifteen columns more of spatial motion.
/// Throws DataError with file and line.
std::vector<PoseCovariance> read_covariances(const std::filesystem::path& file);

/// How covariances are scored.
struct ConsistencyOptions {
  Pose T_reference_estimate = {};  ///< the alignment
  double max_time_gap_s = 1.0;     ///< both trajectories are interpolated over at most this time
  /// A reference without orientation has the positions of this point of the robot, base frame [m].
  Eigen::Vector3d lever_arm_m = Eigen::Vector3d::Zero();
  double reference_sigma_m = 0.0;  ///< of each axis of the reference's positions, independent of the estimate
};

/// Scores the covariances' stamps at which both trajectories are known and the position is not held for certain (σ
/// above 0.1 mm: the files are written to micrometres, and a start that is the map's gauge has no uncertainty).
/// An alignment takes degrees of freedom out of the error, so honest NEES is taken without. Throws Error if the
/// estimate has no orientation, or if there is no common time.
Consistency score_consistency(const std::vector<PoseCovariance>& covariances, const Trajectory& estimate,
                              const Trajectory& reference, const ConsistencyOptions& options);

/// The same of all six of the pose: 6 on the average. Nothing if a covariance has three only, or if the estimate or the
/// reference has no whole orientation. Throws Error if there is no common time.
std::optional<Consistency> score_spatial_consistency(const std::vector<PoseCovariance>& covariances,
                                                     const Trajectory& estimate, const Trajectory& reference,
                                                     const ConsistencyOptions& options);

}  // namespace waymark::evaluation
