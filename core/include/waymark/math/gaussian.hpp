// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "waymark/base/api.hpp"
#include "waymark/math/random.hpp"

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

/// The same, and L with L Lᵀ = S; if S is not positive definite, L is not to be used.
WAYMARK_API Density density(const Vector& nu, const Matrix& S, Matrix& L);

/// A ← A L⁻ᵀ in place, L lower triangular: with A = P Hᵀ and L Lᵀ = S an update subtracts A Aᵀ from P.
template <class A, class L>
void divide_by_factor(A& a, const L& factor) {
  for (Eigen::Index j = 0; j < a.cols(); ++j) {
    for (Eigen::Index i = 0; i < j; ++i) a.col(j) -= factor(j, i) * a.col(i);
    a.col(j) /= factor(j, j);
  }
}

/// The χ² quantile for `dof` degrees of freedom: P(x <= quantile) = probability, 0 < probability < 1.
WAYMARK_API double chi_squared_quantile(double probability, int dof);

/// Symmetric square root B of a positive semi-definite P, so B Bᵀ = P. Negative eigenvalues from rounding count as
/// zero.
WAYMARK_API Eigen::Matrix3d square_root(const Eigen::Matrix3d& P);

/// Eigenvalues, none below zero, and orthonormal eigenvectors as columns.
struct Eigen3 {
  Eigen::Vector3d values;
  Eigen::Matrix3d vectors;
};

/// Of a symmetric positive semi-definite matrix; eigenvalues below 1e-12 × the largest are rounding and become zero.
WAYMARK_API Eigen3 eigen(const Eigen::Matrix3d& P);

/// What P must grow by to be no smaller than `other` (in the sense of ⪰): the positive part of other − P, in units in
/// which the variances of P are one.
WAYMARK_API Eigen::Matrix3d excess(const Eigen::Matrix3d& other, const Eigen::Matrix3d& P);

/// A P⁻¹ for a positive semi-definite P (n × n) and A with n columns: a gain. A state without variance gets no gain.
/// States may have different units.
WAYMARK_API Eigen::MatrixXd divide(const Eigen::MatrixXd& A, const Eigen::MatrixXd& P);

/// A draw from N(0, I).
WAYMARK_API Eigen::Vector3d standard_normal(Random& random);

/// A draw from N(0, P), P positive semi-definite.
WAYMARK_API Eigen::Vector3d sample(const Eigen::Matrix3d& P, Random& random);

/// log Σ exp(values), without overflow; -inf for an empty span or only -inf.
WAYMARK_API double log_sum_exp(const double* values, int count);

}  // namespace waymark::gaussian
