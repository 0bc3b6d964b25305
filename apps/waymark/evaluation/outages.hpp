// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "apps/waymark/evaluation/consistency.hpp"
#include "apps/waymark/evaluation/trajectory_error.hpp"

namespace waymark::evaluation {

/// A span of time without the sensor that bounds the position error.
struct Outage {
  Time begin;
  Time end;  ///< when the sensor is there again
};

/// Reads `30:45`, seconds of the files' clock. Throws Error if it has another shape or does not end after its begin.
Outage parse_outage(std::string_view text);

/// The pauses of a recording that are longer than this [s].
std::vector<Outage> pauses(const Trajectory& recording, double longer_than_s);

/// How outages are scored.
struct OutageOptions {
  double max_time_gap_s = 1.0;  ///< longest pause of the reference to interpolate over
  double settling_s = 2.0;      ///< after the end of an outage: where the pose's largest step is looked for
  Eigen::Vector3d lever_arm_m = Eigen::Vector3d::Zero();  ///< the reference is this point of the robot
};

/// What one outage did to the estimate. Absent is what cannot be known: the truth is not known at that time, or no
/// covariances were given.
struct OutageError {
  Outage outage;
  std::optional<double> position_end_m;   ///< error of what the estimate would have been at the end, nothing new come
  std::optional<double> position_max_m;   ///< largest error in the outage
  std::optional<double> yaw_end_rad;      ///< error at the end
  std::optional<double> sigma_end_m;      ///< predicted σ of the position at the end, in its worst direction
  std::optional<double> error_end_sigma;  ///< √(eᵀ P⁻¹ e) of the position at the end
  std::optional<double> step_m;           ///< largest step of the position while it settles
  std::optional<double> step_sigma;  ///< the step in units of the covariance before it, √(dᵀ P⁻¹ d); its largest
};

/// Scores the estimate over outages. A step is what an estimate differs from the ones before it, moved on at their
/// median velocity; it needs no truth. `covariances` may be empty. `T_reference_estimate` is the alignment.
std::vector<OutageError> score_outages(const std::vector<Outage>& outages, const Trajectory& estimate,
                                       const Trajectory& reference, const std::vector<PoseCovariance>& covariances,
                                       const Pose& T_reference_estimate, const OutageOptions& options);

}  // namespace waymark::evaluation
