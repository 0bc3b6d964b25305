// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "map_modules/octomap_grid/surfels/surfel_map.hpp"
#include "map_modules/shared/scan_matching/scan_settings.hpp"
#include "waymark/interface/nav_state.hpp"
#include "waymark/math/pose.hpp"

namespace waymark::octomap_grid {

/// A Gaussian prior of the base, from which a match starts.
struct SpatialPrior {
  Pose mean;            ///< T_map_base
  SpatialMatrix P;      ///< may be singular
  SpatialVector start;  ///< where the search begins, relative to the mean
};

/// The result of a match about all six of the pose.
struct SpatialMatch {
  SpatialVector d = SpatialVector::Zero();            ///< maximum a posteriori, relative to the prior's mean
  SpatialMatrix information = SpatialMatrix::Zero();  ///< Λ ⪰ 0 of the scan alone, about d
  SpatialVector gradient = SpatialVector::Zero();     ///< η: prior · exp(ηᵀ d − ½ dᵀ Λ d) has its mean at d
  double log_evidence = 0.0;                          ///< tempered log likelihood of the scan, and of d by the prior
  double score = 0.0;                                 ///< mean likelihood of the end points
  bool searched = false;                              ///< from other headings, since the start led to no match
  bool failed = false;                                ///< the prior stands: Λ and η are zero
};

/// How well end points fit planes, at one pose.
struct PlaneFit {
  SpatialMatrix information = SpatialMatrix::Zero();  ///< Λ = Σ w J Jᵀ, of as many residuals as there are planes
  SpatialVector descent = SpatialVector::Zero();      ///< −Σ w J r
  double score = 0.0;                                 ///< mean of L, over all points
  double log_likelihood = 0.0;                        ///< Σ log(0.9 L + 0.1)
};

/// Matches end points to planes (Y. Chen, G. Medioni, 1992: point to plane) by Gauss-Newton with the prior as a term,
/// from the largest cells to the smallest, with residuals that count less the larger they are (S. Geman, D. McClure,
/// 1987). Where that fails, other headings are tried. Holds the storage that this takes; not thread-safe.
class SurfelMatcher {
 public:
  /// `points`: in the base frame, no farther from it than `reach` [m]. Throws Error if they lie outside of what a map
  /// can hold.
  SpatialMatch match(const SurfelMap& map, double cell, std::span<const Eigen::Vector3f> points, double reach,
                     const SpatialPrior& prior, const scan_matching::MatchSettings& settings);

 private:
  struct Optimum {
    SpatialVector d = SpatialVector::Zero();
    SpatialVector pull = SpatialVector::Zero();  // P⁻¹ d, which exists where P does not have an inverse
    PlaneFit fit;
  };

  /// The plane nearest to `p` [m, in the map]: of this level, or of the next larger cells that have one there. What is
  /// far away has few points so far, and alone may say how far the robot has driven.
  SurfelWindow::Plane nearest(int level, const Eigen::Vector3d& p) const;
  /// The fit with the base at prior ⊞ d, to planes of this level and larger ones. `scale`: residuals of this size count
  /// a quarter [m].
  PlaneFit fit(int level, const SpatialPrior& prior, const SpatialVector& d, double scale);
  /// Gauss-Newton steps on one level.
  void descend(int level, const SpatialPrior& prior, double scale, bool is_last, Optimum& at);
  /// Down all levels from `start`.
  Optimum descend_from(const SpatialPrior& prior, const SpatialVector& start);
  /// The heading within the search from which the largest cells fit best.
  SpatialVector best_heading(const SpatialPrior& prior);

  std::span<const Eigen::Vector3f> points_;
  const scan_matching::MatchSettings* settings_ = nullptr;
  std::array<SurfelWindow, SurfelMap::kLevels> windows_;
  std::vector<const Surfel*> used_;  // scratch: the planes of one fit
};

}  // namespace waymark::octomap_grid
