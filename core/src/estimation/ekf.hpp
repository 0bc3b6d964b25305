// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "estimation/georeference.hpp"
#include "waymark/base/api.hpp"
#include "waymark/interface/nav_state.hpp"
#include "waymark/interface/update.hpp"
#include "waymark/math/gaussian.hpp"

/// The extended Kalman filter as functions from belief to belief, without hidden state. The only place, with
/// `ProcessModel`, that touches a covariance.
namespace waymark::estimation::ekf {

/// One update prepared for one belief: what is expected, how uncertain that is, and the gain's ingredients.
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

/// Scatters the linearisation into the active states and computes ν, S and P Hᵀ. `owner` is the sensor's place in the
/// layout. With `earth` the model was linearised at the pose in ENU, and its Jacobians are carried over to the pose in
/// the map and the georeference.
WAYMARK_API void innovate(const Belief& belief, const StateLayout& layout, int owner, const Linearization& model,
                          Innovation& out, const EarthJacobian* earth = nullptr);

/// M Hᵀ, with the Jacobian H of the same linearisation scattered as `innovate` does. M is any size × size matrix, the
/// cross-covariance of two states for example.
WAYMARK_API Innovation::Gain project(const ErrorMatrix& M, const StateLayout& layout, int owner,
                                     const Linearization& model, const EarthJacobian* earth = nullptr);

/// Kalman update: mean ⊞ Kν, and P − W Wᵀ with W = P Hᵀ L⁻ᵀ, which is P − K S Kᵀ and symmetric by construction.
WAYMARK_API void apply(Belief& belief, const StateLayout& layout, const Innovation& innovation);

/// Information about (x, y, yaw) around the mean, Λ ⪰ 0 and η, in Kalman form with Λ = L Lᵀ: P ← P − P Sᵀ L (I + Lᵀ S P
/// Sᵀ L)⁻¹ Lᵀ S P. Valid for singular P and singular Λ (estimation.md §3.2). Returns false and leaves the belief alone
/// if the numbers are not finite.
WAYMARK_API bool apply_pose_information(Belief& belief, const StateLayout& layout, const Eigen::Matrix3d& information,
                                        const Eigen::Vector3d& gradient);

/// FastSLAM's sampling (estimation.md §3.3): δ ~ N(0, a·P_yy) on (x, y, yaw); the rest is conditioned on it and the
/// fraction 1 − a stays as covariance. a in [0, 1].
WAYMARK_API void sample_pose(Belief& belief, const StateLayout& layout, double fraction, Random& random);

/// Sets body velocity and rate to zero with zero covariance, for a robot that stands.
WAYMARK_API void stop(Belief& belief, const StateLayout& layout);

/// Gives velocity and rate a fresh, uncorrelated covariance: the robot starts to move.
WAYMARK_API void release(Belief& belief, const StateLayout& layout, double velocity_sigma, double rate_sigma);

}  // namespace waymark::estimation::ekf
