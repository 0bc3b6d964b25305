// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>

#include "map_modules/shared/scan_matching/descent.hpp"
#include "map_modules/shared/scan_matching/match.hpp"
#include "map_modules/shared/scan_matching/match_target.hpp"
#include "map_modules/shared/scan_matching/scan_settings.hpp"

namespace waymark::scan_matching {

/// Matches scans against likelihood fields: descends (descent.hpp) from the prior's start, or, where the prior is wide,
/// from the best of many draws of it (prior_spread.hpp). Where that fails, descends from the best place of a coarse
/// search (coarse_search.hpp); where nothing fits there either, of one with farther turns, and at last from the best of
/// many draws about the prior, as after a slip (slip.hpp). Where the prior makes a match less likely than none at all,
/// and a slip is likelier than none, the match is that after a slip. Information that only roughness gives along a
/// corridor does not count (weak_direction.hpp).
class ScanMatcher {
 public:
  ScanMatcher(const MatchSettings& settings, double resolution);

  /// How far the field must reach beyond the end points at the prior's mean [m].
  double margin(const MatchPrior& prior) const;
  FoundMatch match(const MatchTarget& target, const MatchPrior& prior) const;
  template <class Field>
  FoundMatch match(const Field& field, std::span<const Eigen::Vector2f> points, const MatchPrior& prior) const {
    return match(PlanarTarget<Field>(field, points, resolution_), prior);
  }

 private:
  /// The match that a descent from `start` leads to; it may have failed.
  Match match_from(const MatchTarget& target, const MatchPrior& prior, const Eigen::Vector3d& start) const;
  /// The same, if the motion slipped. That is in the evidence, by its own probability.
  Match slipped_match_from(const MatchTarget& target, const MatchPrior& prior, const Eigen::Vector3d& start) const;
  /// That of the usual motion; or that of a motion that slipped, if it is likelier than no match, and the usual motion
  /// has no match, or the scan does not fit at the prior's mean, which is nevertheless likelier than that match.
  Match match_or_slip_from(const MatchTarget& target, const MatchPrior& prior, const Eigen::Vector3d& start) const;
  /// The match that the best of many draws about the prior leads to. It has failed unless the points fit as those of
  /// other scans do.
  Match search_slipped(const MatchTarget& target, const MatchPrior& prior) const;
  /// True if the points fit the map as those of other scans do.
  bool fits(const Match& match) const;
  /// True if a match lies where the prior, or the floor of every match, expects it.
  bool is_expected(const MatchPrior& prior, const Eigen::Vector3d& d) const;
  /// Of a match that failed: the scan's evidence at the prior's mean.
  Match prior_alone(const MatchTarget& target, const MatchPrior& prior) const;

  MatchSettings settings_;
  double resolution_;
  FieldTables tables_;
};

}  // namespace waymark::scan_matching
