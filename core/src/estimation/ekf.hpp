// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "estimation/state_jacobian.hpp"
#include "waymark/base/api.hpp"
#include "waymark/interface/nav_state.hpp"
#include "waymark/interface/update.hpp"
#include "waymark/math/gaussian.hpp"

/// The extended Kalman filter as functions from belief to belief, without hidden state. With the rest of
/// this folder the only code that updates a covariance.
namespace waymark::estimation::ekf {

/// One update prepared for one belief: innovation, its covariance, and the terms of the gain.
struct Innovation {
  using Gain = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxErrorStates, kMaxUpdateRows>;
  gaussian::Vector nu;  ///< ν = z ⊟ h(x)
  gaussian::Matrix S;   ///< H P Hᵀ + R
  gaussian::Matrix L;   ///< its Cholesky factor, in the lower half
  Gain PHt;             ///< P Hᵀ, size × rows
  int considered = 0;   ///< this many states, from `first_considered` on, are not estimated
  int first_considered = 0;
  bool finite = false;          ///< false: the model gave NaN or infinity, or S is not positive definite
  gaussian::Density density{};  ///< NIS and log N(ν; 0, S)
};

/// ν, S and P Hᵀ of a linearised model with the Jacobian `H` over the error states.
WAYMARK_API void innovate(const Belief& belief, const Linearization& model, const StateJacobian& H, Innovation& out);

/// M Hᵀ. M is any size × size matrix, the cross-covariance of two states for example.
WAYMARK_API Innovation::Gain project(const ErrorMatrix& M, const StateJacobian& H);

/// Kalman update: mean ⊞ Kν, and P − W Wᵀ with W = P Hᵀ L⁻ᵀ, which is P − K S Kᵀ and symmetric by construction.
WAYMARK_API void apply(Belief& belief, const StateLayout& layout, const Innovation& innovation);

/// Information about (x, y, yaw) around the mean, Λ ⪰ 0 and η, in Kalman form with Λ = L Lᵀ: P ← P − P Sᵀ L (I + Lᵀ S P
/// Sᵀ L)⁻¹ Lᵀ S P. Valid for singular P and singular Λ (docs/math/rbpf.md). Returns false, with an unchanged belief, if
/// a value is not finite.
WAYMARK_API bool apply_pose_information(Belief& belief, const StateLayout& layout, const Eigen::Matrix3d& information,
                                        const Eigen::Vector3d& gradient);

/// The same about all six of the pose, for spatial motion.
WAYMARK_API bool apply_spatial_information(Belief& belief, const StateLayout& layout, const SpatialMatrix& information,
                                           const SpatialVector& gradient);

/// FastSLAM's sampling (docs/math/rbpf.md): δ ~ N(0, a·P_yy) on (x, y, yaw); the rest is conditioned on it and the
/// fraction 1 − a stays as covariance. a in [0, 1].
WAYMARK_API void sample_pose(Belief& belief, const StateLayout& layout, double fraction, Random& random);

/// The same with δ = 0: x, y and yaw are taken as they are.
WAYMARK_API void take_pose(Belief& belief, const StateLayout& layout, double fraction);

/// The same on all six of the pose, for spatial motion.
WAYMARK_API void sample_spatial_pose(Belief& belief, const StateLayout& layout, double fraction, Random& random);

/// The same, but height, roll and pitch are taken as they are: what a map is begun at is level and at this height in
/// it, as the start pose is its origin.
WAYMARK_API void sample_first_spatial_pose(Belief& belief, const StateLayout& layout, double fraction, Random& random);

/// All six are taken as they are.
WAYMARK_API void take_spatial_pose(Belief& belief, const StateLayout& layout, double fraction);

/// Sets body velocity and rate to zero with zero covariance, for standstill.
WAYMARK_API void stop(Belief& belief, const StateLayout& layout);

/// Gives velocity and rate a new, uncorrelated covariance, for the end of a standstill.
WAYMARK_API void release(Belief& belief, const StateLayout& layout, double velocity_sigma, double rate_sigma);

/// Adds a covariance of (x, y, yaw) to the pose's own.
WAYMARK_API void add_pose_covariance(Belief& belief, const StateLayout& layout, const Eigen::Matrix3d& added);

/// Variances to be added to those of a pose, in the map frame.
struct PoseVariance {
  double position = 0.0;  ///< of x and of y [m²]
  double height = 0.0;    ///< [m²]
  double tilt = 0.0;      ///< of roll and of pitch [rad²]
  double yaw = 0.0;       ///< [rad²]
};

/// Adds variance to the pose; planar motion has neither height nor tilt.
WAYMARK_API void inflate_pose(Belief& belief, const StateLayout& layout, const PoseVariance& variance);

}  // namespace waymark::estimation::ekf
