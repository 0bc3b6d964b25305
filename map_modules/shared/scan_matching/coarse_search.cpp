// SPDX-License-Identifier: Apache-2.0
#include "map_modules/shared/scan_matching/coarse_search.hpp"

#include <algorithm>

namespace waymark::scan_matching {

Eigen::Vector3d coarse_search(const MatchTarget& target, const MatchPrior& prior, const LikelihoodTable& wide,
                              const MatchSettings& settings, double resolution) {
  const double step = std::max(resolution, MatchSettings::kSearchStep * settings.wide_sigma);
  const int shifts = static_cast<int>(settings.coarse_distance / step);
  const int turns = static_cast<int>(settings.coarse_angle / MatchSettings::kSearchYawStep);
  Eigen::Vector3d best = prior.start;
  double best_sum = -1.0;
  for (int turn = -turns; turn <= turns; ++turn) {
    for (int y = -shifts; y <= shifts; ++y) {
      for (int x = -shifts; x <= shifts; ++x) {
        const Eigen::Vector3d d =
            prior.start + Eigen::Vector3d(x * step, y * step, turn * MatchSettings::kSearchYawStep);
        const double sum = target.sum_likelihood(wide, prior.mean + d);
        if (sum <= best_sum) continue;
        best_sum = sum;
        best = d;
      }
    }
  }
  return best;
}

}  // namespace waymark::scan_matching
