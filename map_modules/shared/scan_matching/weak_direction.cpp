// SPDX-License-Identifier: Apache-2.0
#include "map_modules/shared/scan_matching/weak_direction.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "waymark/math/gaussian.hpp"

namespace waymark::scan_matching {

WeakDirection find_weak_direction(const MatchTarget& target, const LikelihoodTable& wide, const Eigen::Vector3d& at,
                                  const Eigen::Matrix3d& information, double shift) {
  constexpr double kWeak = 0.5;    // of the strongest direction's information: above, nothing is in doubt
  constexpr double kRough = 0.01;  // of the likelihood: by so much roughness changes it, at most
  WeakDirection weak;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> planar(information.topLeftCorner<2, 2>());
  if (planar.eigenvalues().x() > kWeak * planar.eigenvalues().y()) return weak;
  weak.direction = planar.eigenvectors().col(0);
  const Eigen::Vector3d step(shift * weak.direction.x(), shift * weak.direction.y(), 0.0);
  const double best = target.fit(wide, at).score;
  const double fall = best - std::max(target.fit(wide, at + step).score, target.fit(wide, at - step).score);
  weak.share = std::clamp(fall / (kRough * best) - 1.0, 0.0, 1.0);
  return weak;
}

Optimum without_weak_direction(const Optimum& optimum, const WeakDirection& weak, const MatchTarget& target,
                               const MatchPrior& prior, const LikelihoodTable& narrow) {
  // The scan's own best place, without its share along the weak direction; then with the prior again.
  const gaussian::Eigen3 eigen = gaussian::eigen(optimum.information);
  const Eigen::Vector3d inverse = eigen.values.unaryExpr([](double l) { return l > 0.0 ? 1.0 / l : 0.0; });
  const Eigen::Vector3d best =
      optimum.d + eigen.vectors * inverse.asDiagonal() * eigen.vectors.transpose() * optimum.pull;
  Eigen::Matrix3d kept = Eigen::Matrix3d::Identity();
  kept.topLeftCorner<2, 2>() -= (1.0 - std::sqrt(weak.share)) * weak.direction * weak.direction.transpose();
  Optimum result;
  result.information = kept * optimum.information * kept;
  result.pull = posterior_pull(prior, result.information, result.information * best);
  result.d = prior.P * result.pull;
  result.fit = target.fit(narrow, prior.mean + result.d);
  return result;
}

}  // namespace waymark::scan_matching
