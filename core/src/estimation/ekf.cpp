// SPDX-License-Identifier: Apache-2.0
#include "estimation/ekf.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

namespace waymark::estimation::ekf {

namespace {

/// The columns of H that are not zero, gathered: a position fix has two, so P Hᵀ costs n × 2 instead of n × n.
struct SparseJacobian {
  std::array<int, kMaxErrorStates> states;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxUpdateRows, kMaxErrorStates> columns;
  int count = 0;
};

template <class Column>
void add(SparseJacobian& out, int state, const Column& column) {
  if (state < 0 || column.isZero(0.0)) return;
  out.states[static_cast<std::size_t>(out.count)] = state;
  out.columns.col(out.count++) = column;
}

/// The chain rule through enu_T_map: δp_enu = R δp + δt + (ẑ × R p) δψ, δθ_enu = R δθ + ẑ δψ.
void add_through_earth(const StateLayout& layout, const Linearization& model, const EarthJacobian& earth,
                       SparseJacobian& out) {
  using Jacobian = Linearization::Jacobian3;
  const Jacobian zero = Jacobian::Zero(model.rows(), 3);
  const Jacobian& Hp = model.uses(Linearization::kPosition) ? model.get(Linearization::kPosition) : zero;
  const Jacobian& Ha = model.uses(Linearization::kAttitude) ? model.get(Linearization::kAttitude) : zero;
  const Jacobian p = Hp * earth.R_enu_map;
  const Jacobian a = Ha * earth.R_enu_map;
  for (int axis = 0; axis < 3; ++axis) {
    add(out, layout.active(axis), p.col(axis));
    add(out, layout.active(3 + axis), a.col(axis));
  }
  const int shifts = earth.has_height ? 3 : 2;
  for (int axis = 0; axis < shifts; ++axis) add(out, earth.first_state + axis, Hp.col(axis));
  add(out, earth.first_state + shifts,
      (Hp * Eigen::Vector3d(-earth.lever_enu.y(), earth.lever_enu.x(), 0.0) + Ha.col(2)).eval());
}

void gather(const StateLayout& layout, int owner, const Linearization& model, const EarthJacobian* earth,
            SparseJacobian& out) {
  out.count = 0;
  out.columns.resize(model.rows(), layout.size());
  if (earth != nullptr) add_through_earth(layout, model, *earth, out);
  for (int part = earth != nullptr ? 2 : 0; part < 4; ++part) {
    const auto p = static_cast<Linearization::Part>(part);
    if (!model.uses(p)) continue;
    for (int axis = 0; axis < 3; ++axis) add(out, layout.active(3 * part + axis), model.get(p).col(axis));
  }
  if (model.uses_block()) {
    const int first = layout.core_size() + layout.block_offset(owner);
    for (int i = 0; i < model.get_block().cols(); ++i) add(out, first + i, model.get_block().col(i));
  }
}

/// M Hᵀ, column by column of H that is not zero.
void multiply(const ErrorMatrix& M, const SparseJacobian& H, int rows, Innovation::Gain& out) {
  out.setZero(M.rows(), rows);
  for (int k = 0; k < H.count; ++k) {
    const int state = H.states[static_cast<std::size_t>(k)];
    for (int r = 0; r < rows; ++r) out.col(r) += H.columns(r, k) * M.col(state);
  }
}

}  // namespace

Innovation::Gain project(const ErrorMatrix& M, const StateLayout& layout, int owner, const Linearization& model,
                         const EarthJacobian* earth) {
  SparseJacobian H;
  gather(layout, owner, model, earth, H);
  Innovation::Gain out;
  multiply(M, H, model.rows(), out);
  return out;
}

void innovate(const Belief& belief, const StateLayout& layout, int owner, const Linearization& model, Innovation& out,
              const EarthJacobian* earth) {
  SparseJacobian H;
  gather(layout, owner, model, earth, H);
  const int rows = model.rows();
  out.nu = model.residual;
  out.first_considered = out.considered = 0;
  if (model.uses_block() && !model.estimates_block()) {
    out.considered = static_cast<int>(model.get_block().cols());
    out.first_considered = layout.core_size() + layout.block_offset(owner);
  }
  multiply(belief.P, H, rows, out.PHt);
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
  // Schmidt's update is the optimal one but for the considered states: their gain is zero, their covariance stays.
  const int first = innovation.first_considered;
  const int n = innovation.considered;
  ErrorVector delta = W.lazyProduct(white);
  delta.segment(first, n).setZero();
  const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxBlockStates, kMaxBlockStates> kept =
      belief.P.block(first, first, n, n);
  boxplus(belief.mean, delta, layout);
  belief.P -= W.lazyProduct(W.transpose());
  belief.P.block(first, first, n, n) = kept;
}

namespace {

using PoseColumns = Eigen::Matrix<double, Eigen::Dynamic, 3, 0, kMaxErrorStates, 3>;

/// A pose variance below this [m², rad²] is what rounding left of one that was sampled. Conditioning on it would divide
/// the rounding of its covariances with other states by it, scan after scan while the robot stands.
constexpr double kRounding = 1e-12;

/// The columns of P that belong to x, y and yaw.
PoseColumns pose_columns(const Belief& belief, const StateLayout& layout) {
  PoseColumns columns(layout.size(), 3);
  for (int i = 0; i < 3; ++i) columns.col(i) = belief.P.col(layout.pose_indices()[static_cast<std::size_t>(i)]);
  return columns;
}

}  // namespace

bool apply_pose_information(Belief& belief, const StateLayout& layout, const Eigen::Matrix3d& information,
                            const Eigen::Vector3d& gradient) {
  if (!information.allFinite() || !gradient.allFinite()) return false;
  const PoseColumns PSt = pose_columns(belief, layout);
  const Eigen::Matrix3d Pyy = pose_covariance(belief, layout);
  const Eigen::Matrix3d L = gaussian::square_root(0.5 * (information + information.transpose()));
  const Eigen::Matrix3d inner = Eigen::Matrix3d::Identity() + L.transpose() * Pyy * L;
  const Eigen::LLT<Eigen::Matrix3d> factor(inner);
  if (factor.info() != Eigen::Success) return false;
  // (I + Λ P)⁻¹ η = η − L (I + Lᵀ P L)⁻¹ Lᵀ P η  (Woodbury), so P is never inverted.
  const Eigen::Vector3d Pg = Pyy * gradient;
  const Eigen::Vector3d weighted = gradient - L * factor.solve(L.transpose() * Pg);
  const ErrorVector delta = PSt.lazyProduct(weighted);
  if (!delta.allFinite()) return false;
  // W Wᵀ with W = P Sᵀ L chol⁻ᵀ: symmetric by construction.
  PoseColumns W = PSt.lazyProduct(L);
  gaussian::divide_by_factor(W, factor.matrixLLT());
  belief.P -= W.lazyProduct(W.transpose());
  boxplus(belief.mean, delta, layout);
  return true;
}

void sample_pose(Belief& belief, const StateLayout& layout, double fraction, Random& random) {
  // With P_yy = V Λ Vᵀ and W = P Sᵀ V Λ^(−½) the draw is W ξ, and W Wᵀ is what the condition on it takes away. A
  // direction without variance is neither drawn nor conditioned on.
  const gaussian::Eigen3 eigen = gaussian::eigen(pose_covariance(belief, layout));
  PoseColumns W = pose_columns(belief, layout).lazyProduct(eigen.vectors);
  for (int i = 0; i < 3; ++i) W.col(i) *= eigen.values(i) > kRounding ? 1.0 / std::sqrt(eigen.values(i)) : 0.0;
  const Eigen::Vector3d draw = std::sqrt(fraction) * (eigen.vectors.transpose() * gaussian::standard_normal(random));
  boxplus(belief.mean, W.lazyProduct(draw), layout);
  belief.P -= fraction * W.lazyProduct(W.transpose());
  // What rounding leaves below zero would make the next square root complain.
  for (int i = 0; i < layout.size(); ++i) belief.P(i, i) = std::max(belief.P(i, i), 0.0);
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

}  // namespace waymark::estimation::ekf
