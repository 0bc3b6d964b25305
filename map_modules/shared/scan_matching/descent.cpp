// SPDX-License-Identifier: Apache-2.0
#include "map_modules/shared/scan_matching/descent.hpp"

#include <Eigen/LU>

namespace waymark::scan_matching {

namespace {

// Steps below these end a stage: the wide one need only lead into the narrow one's basin.
const Eigen::Vector3d kWideStep(3e-3, 3e-3, 1e-3);
const Eigen::Vector3d kNarrowStep(2e-4, 2e-4, 1e-4);

bool is_small(const Eigen::Vector3d& step, const Eigen::Vector3d& bound) {
  return (step.array().abs() < bound.array()).all();
}

}  // namespace

Eigen::Vector3d posterior_pull(const MatchPrior& prior, const Eigen::Matrix3d& information,
                               const Eigen::Vector3d& gradient) {
  return (Eigen::Matrix3d::Identity() + information * prior.P).partialPivLu().solve(gradient);
}

Optimum descend(const MatchTarget& target, const MatchPrior& prior, const Eigen::Vector3d& start,
                const FieldTables& tables, const MatchSettings& settings) {
  const double kappa = settings.curvature_scale;
  Optimum at;
  at.d = start;
  for (const bool narrow : {false, true}) {
    for (int i = 0; i < settings.max_iterations; ++i) {
      at.fit = target.fit(narrow ? tables.narrow : tables.wide, prior.mean + at.d);
      at.information = kappa * at.fit.JtJ;
      const Eigen::Vector3d gradient = at.information * at.d + kappa * at.fit.Jtr;
      at.pull = posterior_pull(prior, at.information, gradient);
      const Eigen::Vector3d next = prior.P * at.pull;
      const Eigen::Vector3d step = next - at.d;
      at.d = next;
      if (is_small(step, narrow ? kNarrowStep : kWideStep)) break;
    }
  }
  return at;
}

}  // namespace waymark::scan_matching
