// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

namespace waymark::scan_matching {

/// A Gaussian prior of the base, from which a match starts.
struct MatchPrior {
  Eigen::Vector3d mean;   ///< x [m], y [m], yaw [rad]
  Eigen::Matrix3d P;      ///< may be singular
  Eigen::Vector3d start;  ///< where the search begins, relative to the mean
};

/// The result of a match.
struct Match {
  Eigen::Vector3d d = Eigen::Vector3d::Zero();            ///< maximum a posteriori, relative to the prior's mean
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  ///< Λ ⪰ 0 of the scan alone, about d
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();  ///< η: prior · exp(ηᵀ d − ½ dᵀ Λ d) has its mean at d
  double log_evidence = 0.0;                           ///< tempered log likelihood of the scan, and of d by the prior
  double score = 0.0;                                  ///< mean likelihood of the end points
  Eigen::Vector3d slip = Eigen::Vector3d::Zero();      ///< variance that the prior lacks, if the motion slipped
  bool searched = false;  ///< coarsely, since the start led to no match, or in all of a wide prior
  bool misfits = false;   ///< it contradicts the map where the prior expects it, although the prior is narrow
  bool failed = false;    ///< the prior stands: Λ and η are zero
};

/// A match, and if the prior does not expect it, what there is without it.
struct FoundMatch {
  Match match;
  std::optional<Match> expected = std::nullopt;  ///< the best match that the prior expects; it may have failed
};

}  // namespace waymark::scan_matching
