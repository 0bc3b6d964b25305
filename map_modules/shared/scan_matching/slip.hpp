// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "map_modules/shared/scan_matching/match.hpp"
#include "map_modules/shared/scan_matching/scan_settings.hpp"

/// The second mode of the motion: wheels that slip, or readings that come late, miss a turn by more than any noise
/// says. The prior is then wider, and the mode has a probability of its own.
namespace waymark::scan_matching {

constexpr double kSlipLogProbability = -7.0;  ///< one step of a thousand

/// True if the prior's σ is within the coarse search: then a motion beyond the search is a slip, not noise.
bool may_have_slipped(const MatchPrior& prior, const MatchSettings& settings);

/// Variance of (x [m²], y, yaw [rad²]) that a slip adds: the squares of `coarse_distance` and of `kFartherTurns` times
/// `coarse_angle`.
Eigen::Vector3d slip_variance(const MatchSettings& settings);

/// The prior of a motion that slipped.
MatchPrior after_slip(const MatchPrior& prior, const MatchSettings& settings);

}  // namespace waymark::scan_matching
