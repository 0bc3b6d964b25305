// SPDX-License-Identifier: Apache-2.0
#include "estimation/process_model.hpp"

#include <cassert>
#include <cmath>

#include "waymark/math/so3.hpp"

namespace waymark::estimation {

namespace {

/// Adds the noise of a chain pose ← velocity ← white acceleration with densities [unit²/s], one per axis: A =
/// ∂pose/∂velocity over dt is linear in time, so the integrals are dt/3, dt/2 and dt.
template <int N, class Q>
void add_chain_noise(Q& noise, int pose, int velocity, const Eigen::Matrix<double, N, N>& jacobian,
                     const Eigen::Matrix<double, N, 1>& density, double dt) {
  const Eigen::Matrix<double, N, N> noisy = jacobian * density.asDiagonal();
  const Eigen::Matrix<double, N, N> both = (dt / 2.0) * noisy;
  noise.template block<N, N>(pose, pose) += (dt / 3.0) * noisy.lazyProduct(jacobian.transpose());
  noise.template block<N, N>(pose, velocity) += both;
  noise.template block<N, N>(velocity, pose) += both.transpose();
  noise.template block<N, N>(velocity, velocity).diagonal() += dt * density;
}

/// What is left over `dt` [s] of a block state's distance from zero.
double decay_of(const BlockState& state, double dt) { return state.tau_s > 0.0 ? std::exp(-dt / state.tau_s) : 1.0; }

/// sin(x)/x and (1 − cos x)/x with their derivatives by x: the translation of an arc in the plane.
struct Arc {
  double s, c, ds, dc;
};

Arc arc(double x) {
  if (std::abs(x) < 1e-3) {
    const double x2 = x * x;
    return {1.0 - x2 / 6.0, x / 2.0 - x * x2 / 24.0, -x / 3.0 + x * x2 / 30.0, 0.5 - x2 / 8.0};
  }
  const double sin_x = std::sin(x);
  const double cos_x = std::cos(x);
  const double s = sin_x / x;
  const double c = (1.0 - cos_x) / x;
  return {s, c, (cos_x - s) / x, (sin_x - c) / x};
}

/// P ← F P Fᵀ + Q with F the identity plus G in its first rows: only the rows and columns of the pose change.
template <int kPose, int kCore>
void propagate(ErrorMatrix& P, const Eigen::Matrix<double, kPose, kCore>& G,
               const Eigen::Matrix<double, kCore, kCore>& Q) {
  Eigen::Matrix<double, Eigen::Dynamic, kPose, 0, kMaxErrorStates, kPose> PGt(P.rows(), kPose);
  PGt.setZero();
  for (int j = 0; j < kPose; ++j) {
    for (int k = 0; k < kCore; ++k) {
      if (G(j, k) != 0.0) PGt.col(j) += G(j, k) * P.col(k);
    }
  }
  const Eigen::Matrix<double, kPose, kPose> GPGt = G.lazyProduct(PGt.template topRows<kCore>());
  P.template leftCols<kPose>() += PGt;
  P.template topRows<kPose>() += PGt.transpose();
  P.template topLeftCorner<kPose, kPose>() += GPGt;
  P.template topLeftCorner<kCore, kCore>() += Q;
}

}  // namespace

void ProcessModel::predict_mean(NavState& mean, double dt) const {
  predict_pose(mean, dt);
  for (int i = 0; i < layout_.block_size(); ++i) mean.block[i] *= decay_of(layout_.block_state(i), dt);
}

void ProcessModel::predict_pose(NavState& mean, double dt) const {
  if (layout_.motion() == StateLayout::Motion::planar) {
    const double turn = mean.w_base.z() * dt;
    const Arc a = arc(turn);
    const Eigen::Vector3d d(dt * (a.s * mean.v_base.x() - a.c * mean.v_base.y()),
                            dt * (a.c * mean.v_base.x() + a.s * mean.v_base.y()), 0.0);
    mean.T_map_base.p += mean.T_map_base.q * d;
    mean.T_map_base.q =
        (mean.T_map_base.q * Eigen::Quaterniond(std::cos(0.5 * turn), 0.0, 0.0, std::sin(0.5 * turn))).normalized();
  } else {
    const Eigen::Vector3d phi = mean.w_base * dt;
    mean.T_map_base.p += mean.T_map_base.q * (so3::left_jacobian(phi) * mean.v_base * dt);
    mean.T_map_base.q = (mean.T_map_base.q * so3::exp(phi)).normalized();
  }
}

ProcessModel::PlanarStep ProcessModel::planar_step(const NavState& mean, double dt, bool standing) const {
  const double x = mean.w_base.z() * dt;
  const Arc a = arc(x);
  const double vx = mean.v_base.x();
  const double vy = mean.v_base.y();
  // R is the planar part of the attitude: cos and sin of the yaw from the quaternion, without an arc tangent.
  const Eigen::Quaterniond& q = mean.T_map_base.q;
  const double cos_yaw = q.w() * q.w() - q.z() * q.z();
  const double sin_yaw = 2.0 * q.w() * q.z();
  Eigen::Matrix2d R;
  R << cos_yaw, -sin_yaw, sin_yaw, cos_yaw;
  Eigen::Matrix2d J;  // d(base)/d(v)
  J << dt * a.s, -dt * a.c, dt * a.c, dt * a.s;
  const Eigen::Matrix2d A = R * J;
  const Eigen::Vector2d d = A * Eigen::Vector2d(vx, vy);
  const Eigen::Vector2d C = dt * dt * (R * Eigen::Vector2d(a.ds * vx - a.dc * vy, a.dc * vx + a.ds * vy));

  PlanarStep step;
  auto& [G, Q] = step;
  G.block<2, 2>(0, 3) = A;
  G(0, 2) = -d.y();
  G(1, 2) = d.x();
  G.block<2, 1>(0, 5) = C;
  G(2, 5) = dt;
  if (standing) return step;

  const Eigen::Vector2d Sv = noise_.velocity_per_sqrt_s.head<2>().cwiseAbs2();
  const double Sw = noise_.rate_per_sqrt_s.z() * noise_.rate_per_sqrt_s.z();
  add_chain_noise<2>(Q, 0, 3, A, Sv, dt);
  Q(2, 2) += Sw * dt * dt * dt / 3.0;
  Q(2, 5) += Sw * dt * dt / 2.0;
  Q(5, 2) += Sw * dt * dt / 2.0;
  Q(5, 5) += Sw * dt;
  Q.block<2, 2>(0, 0) += (Sw * dt / 5.0) * C * C.transpose();
  Q.block<2, 1>(0, 2) += (Sw * dt * dt / 4.0) * C;
  Q.block<1, 2>(2, 0) += (Sw * dt * dt / 4.0) * C.transpose();
  Q.block<2, 1>(0, 5) += (Sw * dt / 3.0) * C;
  Q.block<1, 2>(5, 0) += (Sw * dt / 3.0) * C.transpose();
  return step;
}

ProcessModel::SpatialStep ProcessModel::spatial_step(const NavState& mean, double dt, bool standing) const {
  const Eigen::Matrix3d R = mean.T_map_base.q.toRotationMatrix();
  const Eigen::Vector3d phi = mean.w_base * dt;
  const Eigen::Matrix3d J = so3::left_jacobian(phi);
  const Eigen::Vector3d d = R * (J * mean.v_base * dt);
  const Eigen::Matrix3d A = R * J * dt;  // ∂p/∂v, and ∂attitude/∂omega
  const Eigen::Matrix3d C = R * so3::left_jacobian_times_vector_derivative(phi, mean.v_base * dt) * dt;  // ∂p/∂omega

  SpatialStep step;
  auto& [G, Q] = step;
  G.block<3, 3>(0, 3) = -so3::skew(d);
  G.block<3, 3>(0, 6) = A;
  G.block<3, 3>(0, 9) = C;
  G.block<3, 3>(3, 9) = A;
  if (standing) return step;

  const Eigen::Vector3d Sv = noise_.velocity_per_sqrt_s.cwiseAbs2();
  const Eigen::Vector3d Sw = noise_.rate_per_sqrt_s.cwiseAbs2();
  add_chain_noise<3>(Q, 0, 6, A, Sv, dt);
  add_chain_noise<3>(Q, 3, 9, A, Sw, dt);
  const Eigen::Matrix3d noisy = C * Sw.asDiagonal();
  Q.block<3, 3>(0, 0) += (dt / 5.0) * noisy.lazyProduct(C.transpose());
  const Eigen::Matrix3d p_theta = (dt / 4.0) * noisy.lazyProduct(A.transpose());
  Q.block<3, 3>(0, 3) += p_theta;
  Q.block<3, 3>(3, 0) += p_theta.transpose();
  const Eigen::Matrix3d p_omega = (dt / 3.0) * noisy;
  Q.block<3, 3>(0, 9) += p_omega;
  Q.block<3, 3>(9, 0) += p_omega.transpose();
  return step;
}

ErrorMatrix ProcessModel::transition(const NavState& mean, double dt) const {
  ErrorMatrix F = ErrorMatrix::Identity(layout_.size(), layout_.size());
  if (layout_.motion() == StateLayout::Motion::planar) {
    F.topLeftCorner<3, 6>() += planar_step(mean, dt, true).G;
  } else {
    F.topLeftCorner<6, 12>() += spatial_step(mean, dt, true).G;
  }
  for (int i = 0; i < layout_.block_size(); ++i) {
    const int k = layout_.core_size() + i;
    F(k, k) = decay_of(layout_.block_state(i), dt);
  }
  return F;
}

void ProcessModel::predict_blocks(Belief& belief, double dt, bool standing) const {
  const double distance = standing ? 0.0 : belief.mean.v_base.norm() * dt;
  for (int i = 0; i < layout_.block_size(); ++i) {
    const BlockState& state = layout_.block_state(i);
    const int k = layout_.core_size() + i;
    double growth = state.walk_per_sqrt_m * state.walk_per_sqrt_m * distance;
    if (state.tau_s > 0.0) {
      const double decay = decay_of(state, dt);
      belief.mean.block[i] *= decay;
      belief.P.row(k) *= decay;
      belief.P.col(k) *= decay;
      growth += state.stationary_sigma * state.stationary_sigma * (1.0 - decay * decay);
    } else {
      growth += state.walk_per_sqrt_s * state.walk_per_sqrt_s * dt;
    }
    belief.P(k, k) += growth;
  }
}

void ProcessModel::predict(Belief& belief, Time to, bool standing) const {
  assert(to >= belief.stamp);
  const double dt = to_seconds(to - belief.stamp);
  belief.stamp = to;
  if (dt == 0.0) return;
  if (layout_.motion() == StateLayout::Motion::planar) {
    const PlanarStep step = planar_step(belief.mean, dt, standing);
    propagate(belief.P, step.G, step.Q);
  } else {
    const SpatialStep step = spatial_step(belief.mean, dt, standing);
    propagate(belief.P, step.G, step.Q);
  }
  predict_blocks(belief, dt, standing);
  predict_pose(belief.mean, dt);
}

}  // namespace waymark::estimation
