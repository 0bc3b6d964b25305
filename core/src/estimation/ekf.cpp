// SPDX-License-Identifier: Apache-2.0
#include "estimation/ekf.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>

namespace waymark::estimation::ekf {

namespace {

/// M Hᵀ, column by column of H that is not zero.
void multiply(const ErrorMatrix& M, const StateJacobian& H, Innovation::Gain& out) {
  const auto rows = static_cast<int>(H.columns.rows());
  out.setZero(M.rows(), rows);
  for (int k = 0; k < H.count; ++k) {
    const int state = H.states[static_cast<std::size_t>(k)];
    for (int r = 0; r < rows; ++r) out.col(r) += H.columns(r, k) * M.col(state);
  }
}

/// P −= W Wᵀ. Innovations have 1 to 3 rows nearly always: their columns take one pass over P each.
template <class W>
void subtract_square(ErrorMatrix& P, const W& w) {
  for (Eigen::Index j = 0; j < P.cols(); ++j) {
    switch (w.cols()) {
      case 1:
        P.col(j) -= w(j, 0) * w.col(0);
        break;
      case 2:
        P.col(j) -= w(j, 0) * w.col(0) + w(j, 1) * w.col(1);
        break;
      case 3:
        P.col(j) -= w(j, 0) * w.col(0) + w(j, 1) * w.col(1) + w(j, 2) * w.col(2);
        break;
      default:
        P.col(j) -= w.lazyProduct(w.row(j).transpose());
    }
  }
}

}  // namespace

Innovation::Gain project(const ErrorMatrix& M, const StateJacobian& H) {
  Innovation::Gain out;
  multiply(M, H, out);
  return out;
}

void innovate(const Belief& belief, const Linearization& model, const StateJacobian& H, Innovation& out) {
  const int rows = model.rows();
  out.nu = model.residual;
  out.considered = H.considered;
  out.first_considered = H.first_considered;
  multiply(belief.P, H, out.PHt);
  out.S = model.R;
  for (int k = 0; k < H.count; ++k) {
    const int state = H.states[static_cast<std::size_t>(k)];
    for (int r = 0; r < rows; ++r) out.S.row(r) += H.columns(r, k) * out.PHt.row(state);
  }
  out.S = (0.5 * (out.S + out.S.transpose())).eval();
  out.finite = out.nu.allFinite() && out.S.allFinite();
  if (out.finite) {
    out.density = gaussian::density(out.nu, out.S, out.L);
    out.finite = std::isfinite(out.density.log_density);
  }
}

void apply(Belief& belief, const StateLayout& layout, const Innovation& innovation) {
  Innovation::Gain W = innovation.PHt;
  gaussian::divide_by_factor(W, innovation.L);
  gaussian::Vector white = innovation.nu;
  innovation.L.triangularView<Eigen::Lower>().solveInPlace(white);
  // Schmidt's update is the optimal one except for the consider states: their gain is zero, their covariance stays.
  const int first = innovation.first_considered;
  const int n = innovation.considered;
  ErrorVector delta = W.lazyProduct(white);
  delta.segment(first, n).setZero();
  const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxBlockStates, kMaxBlockStates> kept =
      belief.P.block(first, first, n, n);
  boxplus(belief.mean, delta, layout);
  subtract_square(belief.P, W);
  belief.P.block(first, first, n, n) = kept;
}

namespace {

/// N = 3: x, y and yaw; N = 6: all of the pose.
template <int N>
using PoseColumns = Eigen::Matrix<double, Eigen::Dynamic, N, 0, kMaxErrorStates, N>;
template <int N>
using PoseVector = Eigen::Matrix<double, N, 1>;
template <int N>
using PoseMatrix = Eigen::Matrix<double, N, N>;

/// A pose variance below this [m², rad²] is a rounding residue of sampling. Conditioning on it would divide the
/// rounding errors of its covariances with other states by it, at every scan of a standing robot.
constexpr double kRounding = 1e-12;

/// The columns of P that belong to the pose.
template <int N>
PoseColumns<N> pose_columns(const Belief& belief, const StateLayout& layout) {
  PoseColumns<N> columns(layout.size(), N);
  for (int i = 0; i < N; ++i)
    columns.col(i) = belief.P.col(N == 3 ? layout.pose_indices()[static_cast<std::size_t>(i)] : i);
  return columns;
}

Eigen::Matrix3d square_root(const Eigen::Matrix3d& P) { return gaussian::square_root(P); }
SpatialMatrix square_root(const SpatialMatrix& P) {
  const Eigen::SelfAdjointEigenSolver<SpatialMatrix> eigen(P);
  const SpatialVector roots = eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  return eigen.eigenvectors() * roots.asDiagonal() * eigen.eigenvectors().transpose();
}

/// `Pyy`: covariance of the pose.
template <int N>
bool apply_information(Belief& belief, const StateLayout& layout, const PoseMatrix<N>& Pyy,
                       const PoseMatrix<N>& information, const PoseVector<N>& gradient) {
  if (!information.allFinite() || !gradient.allFinite()) return false;
  const PoseColumns<N> PSt = pose_columns<N>(belief, layout);
  const PoseMatrix<N> symmetric = 0.5 * (information + information.transpose());
  const PoseMatrix<N> L = square_root(symmetric);
  const PoseMatrix<N> inner = PoseMatrix<N>::Identity() + L.transpose() * Pyy * L;
  const Eigen::LLT<PoseMatrix<N>> factor(inner);
  if (factor.info() != Eigen::Success) return false;
  // (I + Λ P)⁻¹ η = η − L (I + Lᵀ P L)⁻¹ Lᵀ P η  (Woodbury), so P is never inverted.
  const PoseVector<N> Pg = Pyy * gradient;
  const PoseVector<N> weighted = gradient - L * factor.solve(L.transpose() * Pg);
  const ErrorVector delta = PSt.lazyProduct(weighted);
  if (!delta.allFinite()) return false;
  // W Wᵀ with W = P Sᵀ L chol⁻ᵀ: symmetric by construction.
  PoseColumns<N> W = PSt.lazyProduct(L);
  gaussian::divide_by_factor(W, factor.matrixLLT());
  subtract_square(belief.P, W);
  boxplus(belief.mean, delta, layout);
  return true;
}

/// `values`, `vectors`: eigenvalues and eigenvectors of the pose's covariance.
template <int N>
void sample(Belief& belief, const StateLayout& layout, double fraction, const PoseVector<N>& values,
            const PoseMatrix<N>& vectors, const PoseVector<N>& normal) {
  // With P_yy = V Λ Vᵀ and W = P Sᵀ V Λ^(−½) the draw is W ξ, and conditioning on it subtracts W Wᵀ. A direction
  // without variance is neither drawn nor conditioned on.
  PoseColumns<N> W = pose_columns<N>(belief, layout).lazyProduct(vectors);
  for (int i = 0; i < N; ++i) W.col(i) *= values(i) > kRounding ? 1.0 / std::sqrt(values(i)) : 0.0;
  const PoseVector<N> draw = std::sqrt(fraction) * (vectors.transpose() * normal);
  boxplus(belief.mean, W.lazyProduct(draw), layout);
  belief.P -= fraction * W.lazyProduct(W.transpose());
  // Rounding may leave negative variances, which have no square root.
  for (int i = 0; i < layout.size(); ++i) belief.P(i, i) = std::max(belief.P(i, i), 0.0);
}

void sample_spatial(Belief& belief, const StateLayout& layout, double fraction, const SpatialVector& normal) {
  const Eigen::SelfAdjointEigenSolver<SpatialMatrix> eigen(spatial_covariance(belief));
  sample<6>(belief, layout, fraction, eigen.eigenvalues(), eigen.eigenvectors(), normal);
}

}  // namespace

bool apply_pose_information(Belief& belief, const StateLayout& layout, const Eigen::Matrix3d& information,
                            const Eigen::Vector3d& gradient) {
  return apply_information<3>(belief, layout, pose_covariance(belief, layout), information, gradient);
}

bool apply_spatial_information(Belief& belief, const StateLayout& layout, const SpatialMatrix& information,
                               const SpatialVector& gradient) {
  return apply_information<6>(belief, layout, spatial_covariance(belief), information, gradient);
}

void sample_pose(Belief& belief, const StateLayout& layout, double fraction, Random& random) {
  const gaussian::Eigen3 eigen = gaussian::eigen(pose_covariance(belief, layout));
  sample<3>(belief, layout, fraction, eigen.values, eigen.vectors, gaussian::standard_normal(random));
}

void take_pose(Belief& belief, const StateLayout& layout, double fraction) {
  const gaussian::Eigen3 eigen = gaussian::eigen(pose_covariance(belief, layout));
  sample<3>(belief, layout, fraction, eigen.values, eigen.vectors, Eigen::Vector3d::Zero());
}

void sample_spatial_pose(Belief& belief, const StateLayout& layout, double fraction, Random& random) {
  SpatialVector normal;
  normal.head<3>() = gaussian::standard_normal(random);
  normal.tail<3>() = gaussian::standard_normal(random);
  sample_spatial(belief, layout, fraction, normal);
}

void sample_first_spatial_pose(Belief& belief, const StateLayout& layout, double fraction, Random& random) {
  sample_pose(belief, layout, fraction, random);
  take_spatial_pose(belief, layout, fraction);
}

void take_spatial_pose(Belief& belief, const StateLayout& layout, double fraction) {
  sample_spatial(belief, layout, fraction, SpatialVector::Zero());
}

namespace {

void set_twist_covariance(Belief& belief, const StateLayout& layout, double velocity_variance, double rate_variance) {
  for (int core = 6; core < kCoreStates; ++core) {
    const int i = layout.active(core);
    if (i < 0) continue;
    belief.P.row(i).setZero();
    belief.P.col(i).setZero();
    belief.P(i, i) = core < 9 ? velocity_variance : rate_variance;
  }
}

}  // namespace

void stop(Belief& belief, const StateLayout& layout) {
  belief.mean.v_base.setZero();
  belief.mean.w_base.setZero();
  set_twist_covariance(belief, layout, 0.0, 0.0);
}

void release(Belief& belief, const StateLayout& layout, double velocity_sigma, double rate_sigma) {
  set_twist_covariance(belief, layout, velocity_sigma * velocity_sigma, rate_sigma * rate_sigma);
}

void add_pose_covariance(Belief& belief, const StateLayout& layout, const Eigen::Matrix3d& added) {
  const auto& pose = layout.pose_indices();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      belief.P(pose[static_cast<std::size_t>(i)], pose[static_cast<std::size_t>(j)]) += added(i, j);
  }
}

void inflate_pose(Belief& belief, const StateLayout& layout, const PoseVariance& variance) {
  const std::array<double, 6> added{variance.position, variance.position, variance.height,
                                    variance.tilt,     variance.tilt,     variance.yaw};
  for (std::size_t core = 0; core < added.size(); ++core) {
    const int i = layout.active(static_cast<int>(core));
    if (i >= 0) belief.P(i, i) += added[core];
  }
}

}  // namespace waymark::estimation::ekf
