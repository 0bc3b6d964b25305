// SPDX-License-Identifier: Apache-2.0
#include "joint/spatial_match.hpp"

#include <array>
#include <cmath>

#include "estimation/state_jacobian.hpp"
#include "waymark/interface/update.hpp"
#include "waymark/math/gaussian.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::joint {

void relate_height_and_tilt(JointGaussian& gaussian, const SpatialMatch& match) {
  constexpr std::array<int, 3> kStates{2, 3, 4};
  const auto [information, gradient] = match.about.height_and_tilt();
  if (!information.allFinite() || !gradient.allFinite()) return;

  // Λ = Wᵀ W, so that the noise is white: ν = W⁻ᵀ η − W d.
  const gaussian::Eigen3 eigen = gaussian::eigen(information);
  const Pose& pose = gaussian.belief().mean.T_map_base;
  const Eigen::Vector3d turn = so3::log(pose.q * match.prior.q.conjugate());
  const Eigen::Vector3d d(pose.p.z() - match.prior.p.z(), turn.x(), turn.y());
  Linearization model;
  model.reset(3, 0);
  model.R.setIdentity();
  estimation::StateJacobian H;
  H.reset(3, static_cast<int>(gaussian.belief().P.rows()));
  Eigen::Matrix3d W = Eigen::Matrix3d::Zero();
  for (int i = 0; i < 3; ++i) {
    if (eigen.values(i) <= 0.0) continue;
    const double root = std::sqrt(eigen.values(i));
    W.row(i) = root * eigen.vectors.col(i).transpose();
    model.residual(i) = eigen.vectors.col(i).dot(gradient) / root - W.row(i).dot(d);
  }
  for (int k = 0; k < 3; ++k) H.add(kStates[static_cast<std::size_t>(k)], W.col(k));
  gaussian.update(model, H);
}

}  // namespace waymark::joint
