// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>

#include "tile_window.hpp"

namespace waymark::grid {

/// L = exp(−d²/(2σ²)) for every stored distance d (S. Thrun, W. Burgard, D. Fox, *Probabilistic Robotics*, 2005, §6.4).
/// One stored distance serves any number of widths.
class LikelihoodTable {
 public:
  LikelihoodTable(double sigma, double resolution);
  float operator[](std::uint8_t distance) const { return values_[distance]; }

 private:
  std::array<float, 256> values_;
};

/// How well end points fit a map, at one pose, and how that changes with (x [m], y [m], yaw [rad]).
struct FieldFit {
  Eigen::Matrix3d JtJ = Eigen::Matrix3d::Zero();  ///< Σ ∇L ∇Lᵀ
  Eigen::Vector3d Jtr = Eigen::Vector3d::Zero();  ///< Σ ∇L (1 − L): half the descent of Σ (1 − L)²
  double score = 0.0;                             ///< mean of L
  double log_likelihood = 0.0;                    ///< Σ log(0.9 L + 0.1)
};

/// L of the end points with the base at `xyyaw`, bilinear between the middles of four cells; 0 outside of the window.
FieldFit fit_points(const TileWindow& window, const LikelihoodTable& table, std::span<const Eigen::Vector2f> points,
                    const Eigen::Vector3d& xyyaw, double resolution);

/// Σ L without interpolation or derivatives, for the coarse search.
double sum_likelihood(const TileWindow& window, const LikelihoodTable& table, std::span<const Eigen::Vector2f> points,
                      const Eigen::Vector3d& xyyaw, double resolution);

}  // namespace waymark::grid
