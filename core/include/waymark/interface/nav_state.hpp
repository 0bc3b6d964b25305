// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "waymark/base/api.hpp"
#include "waymark/base/time.hpp"
#include "waymark/math/pose.hpp"

namespace waymark {

inline constexpr int kCoreStates = 12;      ///< p, attitude, v, omega
inline constexpr int kMaxBlockStates = 12;  ///< all plugin-owned blocks together
inline constexpr int kMaxErrorStates = 24;  ///< the bound of the fixed-maximum matrices
inline constexpr int kMaxUpdateRows = 6;

using BlockVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxBlockStates, 1>;
using ErrorVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxErrorStates, 1>;
using ErrorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxErrorStates, kMaxErrorStates>;

/// The state on its manifold. Always three-dimensional, also for planar motion, so plugins have one type.
struct NavState {
  Pose T_map_base;                                   ///< pose of the base in the map (east, north, up)
  Eigen::Vector3d v_base = Eigen::Vector3d::Zero();  ///< velocity of the base in its own frame [m/s]
  Eigen::Vector3d w_base = Eigen::Vector3d::Zero();  ///< angular rate in the base frame [rad/s]
  BlockVector block;                                 ///< the plugins' own states, in the order of the layout's owners
};

/// Process model of one state of a plugin's block. The filter keeps its correlations with all other states.
struct BlockState {
  std::string name;               ///< for reports, with unit: "offset_east_m"
  double initial = 0.0;           ///< value at the start [unit]
  double initial_sigma = 0.0;     ///< its σ [unit]
  double walk_per_sqrt_s = 0.0;   ///< random walk in time [unit/√s]; not used if tau_s > 0
  double walk_per_sqrt_m = 0.0;   ///< random walk in distance driven [unit/√m]
  double tau_s = 0.0;             ///< > 0: first-order Gauss–Markov with this time constant [s]
  double stationary_sigma = 0.0;  ///< σ of the Gauss–Markov process [unit]
};

/// The states that one sensor appends to the filter's; empty for most sensors.
using StateBlock = std::vector<BlockState>;

/// Indices of the active error states. Core error order: p (map), attitude (map frame, left perturbation), v (base),
/// omega (base); then the blocks. Planar motion keeps x, y, yaw, v_x, v_y, omega_z only.
class WAYMARK_API StateLayout {
 public:
  enum class Motion { planar, spatial };
  /// A sensor, or the georeference, with its states.
  struct Owner {
    std::string name;
    StateBlock block;
  };

  /// Throws ConfigError with the number of states of each owner if the blocks exceed `kMaxBlockStates`.
  StateLayout(Motion motion, std::vector<Owner> owners);

  Motion motion() const { return motion_; }
  int size() const { return size_; }            ///< error states that are active
  int core_size() const { return core_size_; }  ///< 6 or 12
  int block_size() const { return size_ - core_size_; }
  const std::vector<Owner>& owners() const { return owners_; }

  /// Active index of a core error state (0..11), or -1 where planar motion holds it fixed.
  int active(int core_index) const { return active_[static_cast<std::size_t>(core_index)]; }
  /// Active indices of x, y, yaw: what the particle filter samples.
  const std::array<int, 3>& pose_indices() const { return pose_; }
  /// First position of an owner's states within `NavState::block`; its size is the block's.
  int block_offset(int owner) const { return offsets_[static_cast<std::size_t>(owner)]; }
  /// Process model of state `index` of `NavState::block`.
  const BlockState& block_state(int index) const { return *flat_[static_cast<std::size_t>(index)]; }

  StateLayout(const StateLayout&) = delete;
  StateLayout& operator=(const StateLayout&) = delete;

 private:
  Motion motion_;
  std::vector<Owner> owners_;
  std::vector<int> offsets_;
  std::vector<const BlockState*> flat_;
  std::array<int, kCoreStates> active_{};
  std::array<int, 3> pose_{};
  int core_size_ = 0;
  int size_ = 0;
};

/// mean ⊞ delta, in place. `delta` has layout.size() rows.
WAYMARK_API void boxplus(NavState& state, const ErrorVector& delta, const StateLayout& layout);

/// a ⊟ b: the delta with b ⊞ delta = a (in the active states).
WAYMARK_API ErrorVector boxminus(const NavState& a, const NavState& b, const StateLayout& layout);

/// A Gaussian over the state at one time.
struct Belief {
  Time stamp{};
  NavState mean;
  ErrorMatrix P;  ///< covariance of the active error states
};

/// Covariance of (x, y, yaw) of a belief.
WAYMARK_API Eigen::Matrix3d pose_covariance(const Belief& belief, const StateLayout& layout);

}  // namespace waymark
