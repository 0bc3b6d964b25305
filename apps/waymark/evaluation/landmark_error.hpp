// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/waymark/evaluation/consistency.hpp"
#include "apps/waymark/evaluation/trajectory_error.hpp"
#include "apps/waymark/evaluation/trajectory_io.hpp"

namespace waymark::evaluation {

/// How landmarks are scored.
struct LandmarkOptions {
  double match_radius_m = 0.7;
  int min_sightings = 10;  ///< landmarks with fewer do not count
};

/// A map against a survey. A landmark that is not matched but within the radius of a survey point is a duplicate; one
/// that is near none is among the others.
struct LandmarkError {
  std::size_t surveyed = 0;
  std::size_t counted = 0;  ///< landmarks with enough sightings
  std::size_t too_few_sightings = 0;
  std::size_t matched = 0;
  std::size_t duplicates = 0;
  std::size_t others = 0;
  std::vector<std::string> missed;            ///< names of survey points without a landmark
  std::optional<ErrorStatistics> position_m;  ///< of the matched
  std::optional<ErrorStatistics> radius_m;    ///< of the matched whose radius is known on both sides
  std::optional<double> radius_bias_m;        ///< mean of estimated minus surveyed radius
  /// NEES of (east, north) of the matched that have a covariance: 2 on the average if it is right.
  std::optional<Consistency> consistency;

  /// The same map after an SE2 fit of its own matched landmarks, matched again until nothing changes; absent if fewer
  /// than two match.
  struct OwnAlignment {
    Pose T_survey_map;  ///< applied to the landmarks as they are in the file
    std::size_t matched = 0;
    ErrorStatistics position_m;
  };
  std::optional<OwnAlignment> own_alignment;
};

/// Scores `landmarks`, first moved by `T_survey_map` (the alignment of the trajectory, or identity), against `survey`.
LandmarkError score_landmarks(const std::vector<Landmark>& landmarks, const std::vector<Landmark>& survey,
                              const Pose& T_survey_map, const LandmarkOptions& options);

}  // namespace waymark::evaluation
