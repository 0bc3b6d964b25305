// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <vector>

#include "apps/waymark/calibration/innovations.hpp"
#include "apps/waymark/calibration/parameter.hpp"

namespace waymark::calibration {

/// Gives the innovations for changed parameters. May be called by several threads.
using Rerun = std::function<Run(const Eigen::VectorXd& change)>;

/// What a log says about the parameters.
struct Estimate {
  Eigen::VectorXd change;       ///< of each parameter, in its unit, or of its logarithm
  Eigen::VectorXd sigma;        ///< of that, given the log and the prior
  Eigen::VectorXd information;  ///< share of the prior's variance that the log removed: 0: it says nothing, 1: all
  double nis_before = 0.0;      ///< mean of ν' S⁻¹ ν / rows
  double nis_after = 0.0;
  int iterations = 0;
  bool converged = false;
};

/// Maximum likelihood by prediction errors: the parameters under which the filter's innovations are most probable,
/// Σ log N(ν; 0, S), with a Gaussian prior (K. J. Åström, Automatica 16, 1980; R. K. Mehra, IEEE TAC 15, 1970).
/// Scoring with the Fisher information of ν and S; derivatives by central differences of whole runs, on `jobs` threads.
/// For the geometry S counts as given (K.-Y. Liang, S. L. Zeger, Biometrika 73, 1986): the wrong shape of a noise model
/// then does not move it. Outliers count less (P. Huber, 1964). σ is the larger of that of the Fisher information and
/// of the scores' scatter over blocks of time (sandwich; H. White, Econometrica 50, 1982), so that a wrong or
/// correlated noise model does not make it too small. `progress` is called after each iteration.
Estimate estimate(const std::vector<Parameter>& parameters, const Rerun& rerun, int jobs,
                  const std::function<void(const Estimate&)>& progress);

}  // namespace waymark::calibration
