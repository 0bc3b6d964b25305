// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>

#include "likelihood_field.hpp"
#include "scan_settings.hpp"

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
  bool searched = false;      ///< coarsely, since the start led nowhere, or in all of a wide prior
  bool failed = false;        ///< the prior stands: Λ and η are zero
};

/// A scan over the map of one particle.
class MatchTarget {
 public:
  virtual ~MatchTarget() = default;
  /// With the base at `xyyaw`.
  virtual FieldFit fit(const LikelihoodTable& table, const Eigen::Vector3d& xyyaw) const = 0;
  virtual double sum_likelihood(const LikelihoodTable& table, const Eigen::Vector3d& xyyaw) const = 0;
};

/// End points over one field.
template <class Field>
class PlanarTarget final : public MatchTarget {
 public:
  PlanarTarget(const Field& field, std::span<const Eigen::Vector2f> points, double resolution)
      : field_(field), points_(points), resolution_(resolution) {}
  FieldFit fit(const LikelihoodTable& table, const Eigen::Vector3d& xyyaw) const override {
    return fit_points(field_, table, points_, xyyaw, resolution_);
  }
  double sum_likelihood(const LikelihoodTable& table, const Eigen::Vector3d& xyyaw) const override {
    return grid::sum_likelihood(field_, table, points_, xyyaw, resolution_);
  }

 private:
  const Field& field_;
  std::span<const Eigen::Vector2f> points_;
  double resolution_;
};

/// Matches scans against likelihood fields: Gauss-Newton on Σ (1 − L)² with the prior as a term, on a wide field first,
/// for the basin, then on a narrow one. Where that fails, from the best place of a coarse correlative search (E. Olson,
/// ICRA 2009). Along directions that the scan says nothing about, the prior stays as it is.
///
/// A prior that is far wider than that search (a robot that wakes up somewhere in its map) is spread over: the best of
/// many draws of it begins the descent. Each particle has draws of its own, so that likely places that look alike are
/// all found, and the weights decide between them.
class ScanMatcher {
 public:
  ScanMatcher(const MatchSettings& settings, double resolution);

  /// How far the field must reach beyond the end points at the prior's mean [m].
  double margin(const MatchPrior& prior) const;
  Match match(const MatchTarget& target, const MatchPrior& prior) const;
  template <class Field>
  Match match(const Field& field, std::span<const Eigen::Vector2f> points, const MatchPrior& prior) const {
    return match(PlanarTarget<Field>(field, points, resolution_), prior);
  }

 private:
  /// The maximum a posteriori from `d` on, on the narrow field in the end.
  void descend(const MatchTarget& target, const MatchPrior& prior, Eigen::Vector3d d, Match& out) const;
  Eigen::Vector3d search(const MatchTarget& target, const MatchPrior& prior) const;
  bool is_wide(const MatchPrior& prior) const;
  Eigen::Vector3d spread(const MatchTarget& target, const MatchPrior& prior) const;

  MatchSettings settings_;
  double resolution_;
  LikelihoodTable wide_;
  LikelihoodTable narrow_;
};

}  // namespace waymark::grid
