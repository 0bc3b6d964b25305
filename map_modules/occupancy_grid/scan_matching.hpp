// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>

#include "likelihood_field.hpp"
#include "occupancy_grid_settings.hpp"
#include "tile_window.hpp"

namespace waymark::grid {

/// A Gaussian prior of the base, as a match takes it.
struct MatchPrior {
  Eigen::Vector3d mean;   ///< x [m], y [m], yaw [rad]
  Eigen::Matrix3d P;      ///< may be singular
  Eigen::Vector3d start;  ///< where the search begins, relative to the mean
};

/// What a match found.
struct Match {
  Eigen::Vector3d d = Eigen::Vector3d::Zero();            ///< maximum a posteriori, relative to the prior's mean
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  ///< Λ ⪰ 0 of the scan alone, about d
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();  ///< η: prior · exp(ηᵀ d − ½ dᵀ Λ d) has its mean at d
  double log_evidence = 0.0;  ///< tempered log likelihood of the scan, with what the prior says about d
  double score = 0.0;         ///< mean likelihood of the end points
  int evaluations = 0;        ///< of the field
  bool searched = false;      ///< coarsely, since the start led nowhere
  bool failed = false;        ///< the prior stands: Λ and η are zero
};

/// Matches scans against likelihood fields: Gauss-Newton on Σ (1 − L)² with the prior as a term, on a wide field first,
/// for the basin, then on a narrow one. Where that fails, from the best place of a coarse correlative search (E. Olson,
/// ICRA 2009). Along directions that the scan says nothing about, the prior stays as it is.
class ScanMatcher {
 public:
  ScanMatcher(const MatchSettings& settings, double resolution);

  /// How far `window` must reach beyond the end points at the prior's mean and at the start [m].
  double margin() const;
  Match match(const TileWindow& window, std::span<const Eigen::Vector2f> points, const MatchPrior& prior) const;

 private:
  /// The maximum a posteriori from `d` on, on the narrow field in the end.
  void descend(const TileWindow& window, std::span<const Eigen::Vector2f> points, const MatchPrior& prior,
               Eigen::Vector3d d, Match& out) const;
  Eigen::Vector3d search(const TileWindow& window, std::span<const Eigen::Vector2f> points,
                         const MatchPrior& prior) const;

  MatchSettings settings_;
  double resolution_;
  LikelihoodTable wide_;
  LikelihoodTable narrow_;
};

}  // namespace waymark::grid
