// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "map_modules/shared/scan_matching/match.hpp"
#include "map_modules/shared/scan_matching/match_target.hpp"
#include "map_modules/shared/scan_matching/scan_settings.hpp"

namespace waymark::scan_matching {

/// The best place of a coarse correlative search (E. Olson, ICRA 2009) on a lattice about the prior's start, by the sum
/// of likelihoods, relative to the prior's mean. `resolution` is that of the map's cells [m].
Eigen::Vector3d coarse_search(const MatchTarget& target, const MatchPrior& prior, const LikelihoodTable& wide,
                              const MatchSettings& settings, double resolution);

}  // namespace waymark::scan_matching
