// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "waymark/api.hpp"
#include "waymark/random.hpp"

/// Utilities for Gaussians whose covariance may be singular (a sampled pose has none at all).
namespace waymark::gaussian {

/// Small dense types without heap storage: up to 6 rows, the size of an update.
using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 6, 1>;
using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6>;

/// The quadratic form nuᵀ S⁻¹ nu and log N(nu; 0, S), from one Cholesky factor.
struct Density {
  double squared_mahalanobis;  ///< normalised innovation squared [-]
  double log_density;          ///< log N(nu; 0, S)
};

/// S must be symmetric positive definite; otherwise both values are NaN and the caller rejects.
WAYMARK_API Density density(const Vector& nu, const Matrix& S);

/// The χ² quantile for `dof` degrees of freedom: P(x <= quantile) = probability, 0 < probability < 1.
WAYMARK_API double chi_squared_quantile(double probability, int dof);

/// Symmetric square root B of a positive semi-definite P, so B Bᵀ = P. Negative eigenvalues from rounding count as
/// zero.
WAYMARK_API Eigen::Matrix3d square_root(const Eigen::Matrix3d& P);

/// Moore–Penrose inverse of a symmetric positive semi-definite matrix; eigenvalues below 1e-12 × the largest count as
/// zero.
WAYMARK_API Eigen::Matrix3d pseudo_inverse(const Eigen::Matrix3d& P);

/// A draw from N(0, P), P positive semi-definite.
WAYMARK_API Eigen::Vector3d sample(const Eigen::Matrix3d& P, Random& random);

/// log Σ exp(values), without overflow; -inf for an empty span or only -inf.
WAYMARK_API double log_sum_exp(const double* values, int count);

}  // namespace waymark::gaussian
