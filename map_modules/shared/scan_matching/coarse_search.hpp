// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "map_modules/shared/scan_matching/match.hpp"
#include "map_modules/shared/scan_matching/match_target.hpp"
#include "map_modules/shared/scan_matching/scan_settings.hpp"

namespace waymark::scan_matching {

/// A place of a coarse search.
struct FoundPlace {
  Eigen::Vector3d d;         ///< relative to the prior's mean
  double likelihood = -1.0;  ///< sum over the points
};

/// Coarse correlative search (E. Olson, ICRA 2009) for the best place of a lattice about the prior's start, by the sum
/// of likelihoods: a few turns at first, more on request.
class CoarseSearch {
 public:
  /// All must outlive the object. `resolution` is that of the map's cells [m].
  CoarseSearch(const MatchTarget& target, const MatchPrior& prior, const LikelihoodTable& wide,
               const MatchSettings& settings, double resolution);

  /// The best place with turns as far as `coarse_angle` to both sides.
  FoundPlace near() const {
    return best(0, near_turns_, target_.sum_likelihood(wide_, prior_.mean + prior_.start, 0.0));
  }
  /// The best place with turns farther than that, as far as three times the angle; any place if none is better than
  /// `near`.
  FoundPlace farther(const FoundPlace& near) const { return best(near_turns_ + 1, far_turns_, near.likelihood); }

 private:
  /// Among turns of so many steps to both sides; any place if none reaches `least`.
  FoundPlace best(int from, int to, double least) const;
  void try_turn(int turn, double least, FoundPlace& best) const;

  const MatchTarget& target_;
  const MatchPrior& prior_;
  const LikelihoodTable& wide_;
  double step_;  // [m]
  int shifts_;
  int near_turns_;
  int far_turns_;
};

}  // namespace waymark::scan_matching
