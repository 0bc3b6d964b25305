// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "map_modules/shared/scan_matching/match.hpp"
#include "map_modules/shared/scan_matching/match_target.hpp"
#include "map_modules/shared/scan_matching/scan_settings.hpp"

/// A prior that is far wider than the coarse search (a robot that wakes up somewhere in its map) is spread over: the
/// best of many draws of it begins the descent. Each particle has draws of its own, so that likely places that look
/// alike are all found, and the weights decide between them.
namespace waymark::scan_matching {

/// True if the prior's σ is more than so many times the half width of the coarse search.
bool is_wider(const MatchPrior& prior, const MatchSettings& settings, double times);

/// True if the prior's σ is more than four times the half width of the coarse search.
bool is_wide(const MatchPrior& prior, const MatchSettings& settings);

/// How far draws of a wide prior lie from its mean [m]; 0 for others.
double spread_reach(const MatchPrior& prior, const MatchSettings& settings);

/// The best of so many draws of the prior and its start, by the sum of likelihoods, relative to the prior's mean. The
/// same prior has the same draws.
Eigen::Vector3d best_draw(const MatchTarget& target, const MatchPrior& prior, const LikelihoodTable& wide, int draws);

}  // namespace waymark::scan_matching
