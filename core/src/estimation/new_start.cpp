// SPDX-License-Identifier: Apache-2.0
#include "estimation/new_start.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "waymark/base/time.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::estimation {

namespace {

/// σ of 10⁸ m, more than twice around the Earth. From here on the rounding errors of an update exceed the variance of a
/// good fix (10¹⁶ m² · 2⁻⁵³ ≈ 1 m²).
constexpr double kLargestVariance = 1e16;
/// A position farther away is not a place, and squares of its coordinates overflow sooner or later [m].
constexpr double kFarthest = 1e12;
/// A variance below zero by more than this is not a rounding error.
constexpr double kMostNegative = -1e-9;
/// A variance below this is a rounding residue: its correlations have no meaning.
constexpr double kRounding = 1e-12;
/// Correlation matrices are positive definite up to this.
constexpr double kTolerance = 1e-6;
/// σ of roll and pitch after a gap [rad]: the robot may stand on another slope.
constexpr double kTiltSigma = 0.17;

bool is_finite(const NavState& mean) {
  return mean.T_map_base.p.allFinite() && mean.T_map_base.p.cwiseAbs().maxCoeff() < kFarthest &&
         mean.T_map_base.q.coeffs().allFinite() && mean.v_base.allFinite() && mean.w_base.allFinite() &&
         mean.block.allFinite();
}

bool is_positive_definite(const ErrorMatrix& P) {
  const ErrorVector scale =
      P.diagonal().unaryExpr([](double variance) { return variance > kRounding ? 1.0 / std::sqrt(variance) : 0.0; });
  ErrorMatrix correlation = scale.asDiagonal() * P * scale.asDiagonal();
  for (Eigen::Index i = 0; i < P.rows(); ++i) correlation(i, i) = 1.0 + kTolerance;
  return Eigen::LLT<ErrorMatrix>(correlation).info() == Eigen::Success;
}

/// Decay and growth of a state over the time without measurements.
void age(Belief& belief, const StateLayout& layout, int i, double dt) {
  const BlockState& state = layout.block_state(i);
  const int k = layout.core_size() + i;
  const double variance = belief.P(k, k);
  if (state.tau_s > 0.0) {
    const double decay = std::exp(-dt / state.tau_s);
    belief.mean.block[i] *= decay;
    belief.P.row(k) *= decay;
    belief.P.col(k) *= decay;
    belief.P(k, k) += state.stationary_sigma * state.stationary_sigma * (1.0 - decay * decay);
  } else {
    // Without a σ at the start nothing bounds the walk but its time, and that may be the error of a clock.
    constexpr double kLongestWalk = 3600.0;
    const double start = state.initial_sigma * state.initial_sigma;
    const double walk_s = start > 0.0 ? dt : std::min(dt, kLongestWalk);
    const double grown = variance + state.walk_per_sqrt_s * state.walk_per_sqrt_s * walk_s;
    belief.P(k, k) = start > 0.0 ? std::min(grown, std::max(variance, start)) : grown;
  }
}

/// Without correlations; a value that is not finite, or far from what it may be, begins as at the first start.
void begin_block_anew(Belief& belief, const StateLayout& layout, int i) {
  constexpr double kFarSigmas = 10.0;
  const BlockState& state = layout.block_state(i);
  const int k = layout.core_size() + i;
  const double variance = belief.P(k, k);
  belief.P.row(k).setZero();
  belief.P.col(k).setZero();
  double& value = belief.mean.block[i];
  // The map's place on the Earth has no σ of its own at the start: it is that of the start pose.
  const bool has_sigma = state.initial_sigma > 0.0;
  if (!std::isfinite(value) || (has_sigma && std::abs(value - state.initial) > kFarSigmas * state.initial_sigma))
    value = state.initial;
  const double start = state.initial_sigma * state.initial_sigma;
  const bool plausible = variance >= 0.0 && variance <= kLargestVariance;
  belief.P(k, k) = has_sigma ? start : (plausible ? variance : 0.0);
}

/// Copies the covariance of the pose and the twist; z, roll and pitch get one where they are states.
void set_core(Belief& belief, const Belief& start, const StateLayout& layout) {
  const int core = layout.core_size();
  const int blocks = layout.block_size();
  belief.P.topLeftCorner(core, core) = start.P.topLeftCorner(core, core);
  belief.P.topRightCorner(core, blocks).setZero();
  belief.P.bottomLeftCorner(blocks, core).setZero();
  const double variance = start.P(layout.pose_indices()[0], layout.pose_indices()[0]);
  for (int axis = 2; axis < 5; ++axis) {
    const int k = layout.active(axis);
    if (k >= 0) belief.P(k, k) = axis == 2 ? variance : kTiltSigma * kTiltSigma;
  }
}

}  // namespace

bool has_plausible_variances(const Belief& belief) {
  for (Eigen::Index i = 0; i < belief.P.rows(); ++i) {
    if (!(belief.P(i, i) >= kMostNegative && belief.P(i, i) <= kLargestVariance)) return false;
  }
  return true;
}

bool is_sound(const Belief& belief) {
  return has_plausible_variances(belief) && belief.P.allFinite() && is_finite(belief.mean) &&
         is_positive_definite(belief.P);
}

void begin_anew(Belief& belief, const NewStart& start, const StateLayout& layout,
                const std::optional<Georeference>& georeference) {
  const bool was_sound = is_sound(belief);
  const double dt = std::max(to_seconds(start.prior.stamp - belief.stamp), 0.0);
  for (int i = 0; i < layout.block_size(); ++i) {
    if (was_sound) {
      age(belief, layout, i, dt);
    } else {
      begin_block_anew(belief, layout, i);
    }
  }
  belief.stamp = start.prior.stamp;
  belief.mean.v_base = start.prior.mean.v_base;
  belief.mean.w_base = start.prior.mean.w_base;
  set_core(belief, start.prior, layout);

  Pose& pose = belief.mean.T_map_base;
  const bool pose_is_finite = pose.p.allFinite() && pose.q.coeffs().allFinite();
  if (start.keeps_pose && pose_is_finite) return;
  Pose before = start.prior.mean.T_map_base;
  if (pose_is_finite) before = georeference ? georeference->T_enu_map(belief.mean) * pose : pose;
  pose = start.prior.mean.T_map_base;
  if (layout.motion() == StateLayout::Motion::spatial) {
    // Neither a fix nor a course measures height and tilt: they stay.
    const Eigen::Quaterniond tilt = so3::from_rpy(0.0, 0.0, -before.yaw()) * before.q;
    pose.p.z() = before.p.z();
    pose.q = (so3::from_rpy(0.0, 0.0, pose.yaw()) * tilt).normalized();
  }
  if (georeference) georeference->to_map(belief);
}

}  // namespace waymark::estimation
