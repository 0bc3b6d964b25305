// SPDX-License-Identifier: Apache-2.0
#include "map_modules/shared/scan_matching/slip.hpp"

#include "map_modules/shared/scan_matching/prior_spread.hpp"

namespace waymark::scan_matching {

bool may_have_slipped(const MatchPrior& prior, const MatchSettings& settings) {
  return settings.spread_draws > 0 && !is_wider(prior, settings, 1.0);
}

Eigen::Vector3d slip_variance(const MatchSettings& settings) {
  const double turn = MatchSettings::kFartherTurns * settings.coarse_angle;
  return Eigen::Vector3d(settings.coarse_distance, settings.coarse_distance, turn).cwiseAbs2();
}

MatchPrior after_slip(const MatchPrior& prior, const MatchSettings& settings) {
  MatchPrior slipped = prior;
  slipped.P.diagonal() += slip_variance(settings);
  return slipped;
}

}  // namespace waymark::scan_matching
