// SPDX-License-Identifier: Apache-2.0
#include "unit/core/beliefs.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <string>

namespace waymark::test {

Eigen::VectorXd normals(int size, Random& random) {
  Eigen::VectorXd v(size);
  for (double& x : v) x = random.normal();
  return v;
}

NavState random_state(const StateLayout& layout, Random& random, double rate) {
  NavState state;
  const bool planar = layout.motion() == StateLayout::Motion::planar;
  for (int i = 0; i < 3; ++i) {
    state.T_map_base.p[i] = uniform(random, -50.0, 50.0);
    state.v_base[i] = uniform(random, -3.0, 3.0);
    state.w_base[i] = uniform(random, -rate, rate);
  }
  const double yaw = uniform(random, -3.1, 3.1);
  const double tilt = planar ? 0.0 : 1.0;
  state.T_map_base.q =
      so3::from_rpy(tilt * uniform(random, -1.0, 1.0), tilt * uniform(random, -1.0, 1.0), yaw).normalized();
  if (planar) {
    state.v_base.z() = 0.0;
    state.w_base.head<2>().setZero();
  }
  state.block.resize(layout.block_size());
  for (double& x : state.block) x = uniform(random, -1.0, 1.0);
  return state;
}

ErrorMatrix random_covariance(int size, Random& random, double scale) {
  Eigen::MatrixXd B(size, size);
  for (int i = 0; i < size; ++i) B.col(i) = normals(size, random);
  return scale * (B * B.transpose() / size + 0.1 * Eigen::MatrixXd::Identity(size, size));
}

double smallest_eigenvalue(const ErrorMatrix& P) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(Eigen::MatrixXd(P), Eigen::EigenvaluesOnly)
      .eigenvalues()
      .minCoeff();
}

double asymmetry(const ErrorMatrix& P) { return (P - P.transpose()).cwiseAbs().maxCoeff(); }

StateBlock block_of(int states) {
  StateBlock block(static_cast<std::size_t>(states));
  for (int i = 0; i < states; ++i) block[static_cast<std::size_t>(i)].name = "state_" + std::to_string(i);
  return block;
}

void innovate(const Belief& belief, const StateLayout& layout, int owner, const Linearization& model,
              estimation::ekf::Innovation& out) {
  estimation::StateJacobian H;
  H.reset(model.rows(), layout.size());
  estimation::scatter(layout, owner < 0 ? 0 : layout.block_offset(owner), model, H);
  estimation::ekf::innovate(belief, model, H, out);
}

}  // namespace waymark::test
