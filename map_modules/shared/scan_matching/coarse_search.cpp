// SPDX-License-Identifier: Apache-2.0
#include "map_modules/shared/scan_matching/coarse_search.hpp"

#include <algorithm>
#include <numbers>

namespace waymark::scan_matching {

namespace {

int steps_of(double angle) { return static_cast<int>(angle / MatchSettings::kSearchYawStep); }

}  // namespace

CoarseSearch::CoarseSearch(const MatchTarget& target, const MatchPrior& prior, const LikelihoodTable& wide,
                           const MatchSettings& settings, double resolution)
    : target_(target),
      prior_(prior),
      wide_(wide),
      step_(std::max(resolution, MatchSettings::kSearchStep * settings.wide_sigma)),
      shifts_(static_cast<int>(settings.coarse_distance / step_)),
      near_turns_(steps_of(settings.coarse_angle)),
      far_turns_(steps_of(std::min(MatchSettings::kFartherTurns * settings.coarse_angle, std::numbers::pi))) {}

FoundPlace CoarseSearch::best(int from, int to, double least) const {
  FoundPlace best{prior_.start};
  for (int turn = -to; turn <= -std::max(from, 1); ++turn) try_turn(turn, least, best);
  for (int turn = from; turn <= to; ++turn) try_turn(turn, least, best);
  return best;
}

void CoarseSearch::try_turn(int turn, double least, FoundPlace& best) const {
  for (int y = -shifts_; y <= shifts_; ++y) {
    for (int x = -shifts_; x <= shifts_; ++x) {
      const Eigen::Vector3d d =
          prior_.start + Eigen::Vector3d(x * step_, y * step_, turn * MatchSettings::kSearchYawStep);
      const double likelihood = target_.sum_likelihood(wide_, prior_.mean + d, std::max(least, best.likelihood));
      if (likelihood > best.likelihood) best = {d, likelihood};
    }
  }
}

}  // namespace waymark::scan_matching
