// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>

#include "apps/waymark/calibration/equations.hpp"

namespace waymark::calibration {

/// What a log says about the parameters.
struct Estimate {
  Eigen::VectorXd change;       ///< of each parameter, in its unit, or of its logarithm
  Eigen::VectorXd sigma;        ///< of that, given the log and the prior
  Eigen::VectorXd information;  ///< share of the prior's variance that the log removed: 0: it says nothing, 1: all
  double largest_step = 0.0;    ///< of the last iteration, in σ
  int iterations = 0;
  bool converged = false;
};

/// Adjusts path and parameters to a recording: least squares by Gauss–Newton, outliers weighted down (P. Huber, 1964),
/// and levels of noise by restricted maximum likelihood with scoring (H. D. Patterson, R. Thompson, Biometrika 58,
/// 1971), whose traces are estimated with fixed random probes (M. F. Hutchinson, 1989). σ is the larger one of that of
/// the normal equations and of the scatter of the parameters' scores over blocks of time (H. White, Econometrica 50,
/// 1982; K.-Y. Liang, S. L. Zeger, Biometrika 73, 1986), so errors that are correlated do not make it too small.
/// `progress` is called after each iteration.
Estimate estimate(const Equations& equations, const std::function<void(const Estimate&)>& progress);

}  // namespace waymark::calibration
