// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

namespace waymark::host::diagnosis {

inline constexpr double kMadToSigma = 1.4826;  ///< σ of what is normally distributed, by its median absolute value

/// Rows of a linear model y = A x, in the order of time.
struct Rows {
  Eigen::MatrixXd A;
  Eigen::VectorXd y;
  Eigen::Index count = 0;

  Rows(Eigen::Index capacity, Eigen::Index columns) : A(capacity, columns), y(capacity) {}
  bool full() const { return count == y.size(); }
};

/// A robust least-squares fit (docs/doctor.md): Tukey's biweight on residuals in units of their own scale (MAD), and a
/// covariance that holds for residuals that are correlated in time: the larger one of the usual covariance and of the
/// jackknife over stretches of the log.
struct Fit {
  Eigen::VectorXd x;
  Eigen::VectorXd sigma;    ///< of each element of x
  Eigen::VectorXd weights;  ///< of the rows, 0 to 1
  double residual = 0.0;    ///< σ of one row
  double kept = 0.0;        ///< sum of the weights by the number of rows
  bool valid = false;       ///< enough rows, and the columns are independent

  /// How far element `i` lies from `expected` beyond `tolerance`, in σ; 0 within it.
  double sigmas(Eigen::Index i, double expected, double tolerance) const;
};

/// `first`: where the iteration begins; empty: at the unweighted solution. `relative`: errors that grow with a row's
/// own size (a lag, a scale that varies), as a share of it: large rows must not count as outliers beside many small
/// ones.
Fit fit_rows(const Rows& rows, const Eigen::VectorXd& first = {}, double relative = 0.0);

/// Slope of y on x between its two extremes: all noise in y, and all noise in x (R. Frisch, 1934). The other columns of
/// the model are taken out of both. `slope` is the index of x among the columns.
struct SlopeBounds {
  double low = 0.0;
  double high = 0.0;
  double correlation2 = 0.0;  ///< partial correlation, squared
  double spread_x = 0.0;      ///< root mean square of what is left of x
};
SlopeBounds slope_bounds(const Rows& rows, const Fit& fit, Eigen::Index slope);

/// The value in the middle; reorders `values`. 0 if there are none.
double median(std::vector<double>& values);

}  // namespace waymark::host::diagnosis
