// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "map_modules/shared/scan_matching/likelihood_field.hpp"
#include "map_modules/shared/scan_matching/match.hpp"
#include "map_modules/shared/scan_matching/match_target.hpp"
#include "map_modules/shared/scan_matching/scan_settings.hpp"

namespace waymark::scan_matching {

/// The two widths of the likelihood field.
struct FieldTables {
  LikelihoodTable wide;    ///< for the basin
  LikelihoodTable narrow;  ///< for the precision
};

/// A maximum a posteriori.
struct Optimum {
  Eigen::Vector3d d;            ///< relative to the prior's mean
  Eigen::Matrix3d information;  ///< κ Σ ∇L ∇Lᵀ, of the scan alone
  Eigen::Vector3d pull;         ///< P⁻¹ d, which exists where P does not have an inverse
  FieldFit fit;                 ///< on the narrow field
};

/// Gauss-Newton on κ Σ (1 − L)² with the prior as a term, from `start` on (relative to the prior's mean): first on the
/// wide field, then on the narrow one. Along directions that the scan does not constrain, the prior stays as it is.
Optimum descend(const MatchTarget& target, const MatchPrior& prior, const Eigen::Vector3d& start,
                const FieldTables& tables, const MatchSettings& settings);

/// P⁻¹ d of the maximum a posteriori of the prior and a scan with this information and gradient: (I + Λ P)⁻¹ η.
Eigen::Vector3d posterior_pull(const MatchPrior& prior, const Eigen::Matrix3d& information,
                               const Eigen::Vector3d& gradient);

}  // namespace waymark::scan_matching
