// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "map_modules/shared/scan_matching/match.hpp"
#include "waymark/interface/particle_map.hpp"

namespace waymark::scan_matching {

/// How a scan matched one particle's map, for its figures.
struct MatchAssociation final : Association {
  struct Outcome {
    enum class Kind : std::uint8_t { not_tried, matched, failed };
    Kind kind = Kind::not_tried;
    bool slipped = false;
    double score = 0.0;
  };

  /// The association that the host keeps in `out`, as new; made if there is none.
  static MatchAssociation& of(Refinement& out);
  /// Gives the match to the host, in the map's axes, and notes how it went. `R_map_match`: of (x, y, yaw), from the
  /// axes of the match.
  void report(const FoundMatch& matches, const Eigen::Matrix3d& R_map_match, Refinement& out);

  Outcome found;
  Outcome if_refused;  ///< what is used if the host refuses what was found
  bool searched = false;
  bool writes = true;  ///< the map is written after this match
};

/// What has happened to a map and its ancestors.
class MatchRecord {
 public:
  void count(const MatchAssociation& how);
  void describe(std::vector<MapFigure>& out) const;
  template <class Archive>
  void serialize(Archive& archive) {
    archive(matches_, failed_, searches_, slips_, score_sum_);
  }

 private:
  std::uint64_t matches_ = 0;
  std::uint64_t failed_ = 0;
  std::uint64_t searches_ = 0;
  std::uint64_t slips_ = 0;
  double score_sum_ = 0.0;  // of the matches
};

/// The planar part of a prior, and where the host starts, relative to it.
MatchPrior planar_prior(const PoseGaussian& prior, const Pose& start);

}  // namespace waymark::scan_matching
