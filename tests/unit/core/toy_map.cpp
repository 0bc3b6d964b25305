// SPDX-License-Identifier: Apache-2.0
#include "unit/core/toy_map.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

namespace waymark::test {

void Sighting::see(const Pose& T_map_base, const Eigen::Vector2d& p_map, const Eigen::Vector2d& noise) {
  const Eigen::Vector3d seen = T_map_base.inverse() * Eigen::Vector3d(p_map.x(), p_map.y(), 0.0);
  landmarks.push_back({p_map, seen.head<2>() + noise});
}

void ToyMap::refine(const PoseGaussian& prior, const Pose&, const Observation& observation, Refinement& out) const {
  if (fails_ == Fails::in_refine) throw std::runtime_error("a toy that breaks in refine");
  const auto& sighting = static_cast<const Sighting&>(observation);
  const auto rows = static_cast<Eigen::Index>(2 * sighting.landmarks.size());
  out.writes = sighting.writes;
  const Eigen::Matrix2d Rt = prior.T_map_base.q.toRotationMatrix().topLeftCorner<2, 2>().transpose();
  const double variance = sighting.sigma_m * sighting.sigma_m;
  Eigen::MatrixXd H(rows, 3);
  Eigen::VectorXd nu(rows);
  for (Eigen::Index i = 0; i < rows; i += 2) {
    const auto& one = sighting.landmarks[static_cast<std::size_t>(i / 2)];
    const Eigen::Vector2d expected = Rt * (one.p_map - prior.T_map_base.p.head<2>());
    H.block<2, 2>(i, 0) = -Rt;
    H.block<2, 1>(i, 2) = Eigen::Vector2d(expected.y(), -expected.x());
    nu.segment<2>(i) = one.p_base - expected;
  }
  out.information = H.transpose() * H / variance;
  out.gradient = H.transpose() * nu / variance;
  const Eigen::MatrixXd S = H * prior.P * H.transpose() + variance * Eigen::MatrixXd::Identity(rows, rows);
  const Eigen::LLT<Eigen::MatrixXd> factor(S);
  const Eigen::VectorXd white = factor.matrixL().solve(nu);
  out.log_evidence = -0.5 * white.squaredNorm() - Eigen::MatrixXd(factor.matrixLLT()).diagonal().array().log().sum() -
                     0.5 * static_cast<double>(rows) * std::log(2.0 * std::numbers::pi);
}
}  // namespace waymark::test
