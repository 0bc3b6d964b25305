// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <string_view>

#include "estimation/state_jacobian.hpp"
#include "waymark/base/api.hpp"
#include "waymark/host/filter_settings.hpp"
#include "waymark/interface/nav_state.hpp"

namespace waymark::estimation {

/// The map's place on the Earth, enu_T_map, as states of the filter (REP-105: earth → map): x, y, yaw, and z where the
/// motion is spatial. The start pose is the map's origin without uncertainty; its uncertainty on the Earth is that of
/// this block. Absolute sensors thus rotate and shift a map that is already written, instead of contradicting it. The
/// block belongs to no sensor; it is the last owner of the layout.
class WAYMARK_API Georeference {
 public:
  /// Name of the owner, for reports only.
  static constexpr std::string_view kOwner = "georeference";
  /// The states to append: x, y, (z,) yaw.
  static StateBlock block(StateLayout::Motion motion, const GeoreferenceSettings& settings);

  /// `owner` is its place in the layout, which must outlive it.
  Georeference(const StateLayout& layout, int owner);

  /// enu_T_map of this state.
  Pose T_enu_map(const NavState& state) const;
  /// The state with its pose in ENU; twist and blocks as they are.
  NavState in_enu(const NavState& state) const;
  /// The belief with its pose in ENU, composed to first order: mean and covariance, correlations included.
  void to_enu(Belief& belief) const;
  /// The inverse of `to_enu`: the belief has its pose in ENU, and gets it in the map. Mean and covariance, correlations
  /// included.
  void to_map(Belief& belief) const;
  /// Scatters the Jacobians of a model that was linearised at `in_enu(state)`: by the chain rule they become those of
  /// the pose in the map and of the map's place on the Earth. Adds to `out`.
  void scatter(const NavState& state, int block_offset, const Linearization& model, StateJacobian& out) const;

  /// Moves the pose of a start prior into the block. The start pose becomes the map's origin, without uncertainty.
  void take_over_start(Belief& prior) const;
  /// Inflates the covariance, so that absolute sensors can correct the map's place on the Earth.
  void inflate(Belief& belief, double position_variance, double yaw_variance) const;
  /// Covariance of (east, north) of a fixed point of the map, due to the map's place on the Earth alone.
  Eigen::Matrix2d point_covariance(const Belief& belief, const Eigen::Vector2d& p_map) const;
  /// Covariance of (east, north) of a point that is uncertain in the map, by `P`, and correlated with the state, by
  /// `cross` (its two states × error states). `state` has the map's place on the Earth.
  Eigen::Matrix2d point_covariance(const Belief& belief, const NavState& state, const Eigen::Vector2d& p_map,
                                   const Eigen::Matrix2d& P,
                                   const Eigen::Ref<const Eigen::Matrix<double, 2, Eigen::Dynamic>>& cross) const;

 private:
  /// Error states of the block's x, y and yaw.
  std::array<int, 3> planar_states() const { return {first_, first_ + 1, first_ + yaw_}; }

  const StateLayout& layout_;
  int offset_;  // within NavState::block
  int first_;   // among the error states
  bool has_height_;
  int yaw_;  // place of the yaw in the block: 2 or 3
};

}  // namespace waymark::estimation
