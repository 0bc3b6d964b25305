// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>

#include "map_modules/shared/scan_matching/likelihood_field.hpp"

namespace waymark::scan_matching {

/// A scan over the map of one particle.
class MatchTarget {
 public:
  virtual ~MatchTarget() = default;
  /// With the base at `xyyaw`.
  virtual FieldFit fit(const LikelihoodTable& table, const Eigen::Vector3d& xyyaw) const = 0;
  /// Where it cannot reach `least`, part of the sum.
  virtual double sum_likelihood(const LikelihoodTable& table, const Eigen::Vector3d& xyyaw, double least) const = 0;
  /// Share of the points that lie behind something that is occupied.
  virtual double blocked_share(const Eigen::Vector3d& xyyaw, Ends ends) const = 0;
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
  double sum_likelihood(const LikelihoodTable& table, const Eigen::Vector3d& xyyaw, double least) const override {
    return scan_matching::sum_likelihood(field_, table, points_, xyyaw, resolution_, least);
  }
  double blocked_share(const Eigen::Vector3d& xyyaw, Ends ends) const override {
    return points_.empty() ? 0.0
                           : static_cast<double>(count_blocked(field_, points_, xyyaw, resolution_, ends)) /
                                 static_cast<double>(points_.size());
  }

 private:
  const Field& field_;
  std::span<const Eigen::Vector2f> points_;
  double resolution_;
};

}  // namespace waymark::scan_matching
