// SPDX-License-Identifier: Apache-2.0
#include "map_modules/shared/scan_matching/prior_spread.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "waymark/math/gaussian.hpp"
#include "waymark/math/random.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::scan_matching {

bool is_wider(const MatchPrior& prior, const MatchSettings& settings, double times) {
  const double distance = times * settings.coarse_distance;
  const double angle = times * settings.coarse_angle;
  return std::max(prior.P(0, 0), prior.P(1, 1)) > distance * distance || prior.P(2, 2) > angle * angle;
}

bool is_wide(const MatchPrior& prior, const MatchSettings& settings) {
  // A place that four times the coarse search finds by chance is no reason to look everywhere.
  constexpr double kFar = 4.0;
  return settings.spread_draws > 0 && is_wider(prior, settings, kFar);
}

double spread_reach(const MatchPrior& prior, const MatchSettings& settings) {
  constexpr double kSpreadSigmas = 4.0;  // no draw is farther away than this, but for one in 3000
  return is_wide(prior, settings) ? kSpreadSigmas * std::sqrt(std::max(prior.P(0, 0), prior.P(1, 1))) : 0.0;
}

Eigen::Vector3d best_draw(const MatchTarget& target, const MatchPrior& prior, const LikelihoodTable& wide, int draws) {
  // The start is the host's draw for this particle and step: a key of its own for the stream.
  // Where only the heading is uncertain x and y are zero for all.
  const auto turn = std::bit_cast<std::uint64_t>(prior.start.z());
  Random random({std::bit_cast<std::uint64_t>(prior.start.x()), static_cast<std::uint32_t>(turn),
                 std::bit_cast<std::int64_t>(prior.start.y()), static_cast<std::uint32_t>(turn >> 32)});
  const Eigen::Matrix3d B = gaussian::square_root(prior.P);
  Eigen::Vector3d best = prior.start;
  double best_sum = target.sum_likelihood(wide, prior.mean + best, 0.0);
  for (int k = 0; k < draws; ++k) {
    Eigen::Vector3d d = B * gaussian::standard_normal(random);
    d.z() = so3::wrap(d.z());
    const double sum = target.sum_likelihood(wide, prior.mean + d, best_sum);
    if (sum <= best_sum) continue;
    best_sum = sum;
    best = d;
  }
  return best;
}

}  // namespace waymark::scan_matching
