// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "waymark/base/api.hpp"
#include "waymark/host/filter_settings.hpp"
#include "waymark/interface/nav_state.hpp"

namespace waymark::estimation {

/// Constant body twist with white acceleration noise, discretised exactly in Δt for the linearised system. Blocks
/// evolve by their `BlockState`. Planar motion uses the closed form of an arc in the plane.
class WAYMARK_API ProcessModel {
 public:
  /// `layout` must outlive the model.
  ProcessModel(const StateLayout& layout, const ProcessNoise& noise) : layout_(layout), noise_(noise) {}

  /// Predicts `belief` to time `to` >= belief.stamp. While `standing`, no noise enters pose and twist.
  void predict(Belief& belief, Time to, bool standing) const;

  /// The mean alone, without covariance.
  void predict_mean(NavState& mean, double dt) const;

  /// Transition matrix of the error state over `dt` [s], size × size.
  ErrorMatrix transition(const NavState& mean, double dt) const;

  const StateLayout& layout() const { return layout_; }

 private:
  /// F of the core states is the identity plus G in the rows of the pose: the twist is constant, the pose integrates
  /// it.
  template <int kPose, int kCore>
  struct CoreStep {
    Eigen::Matrix<double, kPose, kCore> G = Eigen::Matrix<double, kPose, kCore>::Zero();
    Eigen::Matrix<double, kCore, kCore> Q = Eigen::Matrix<double, kCore, kCore>::Zero();
  };
  using PlanarStep = CoreStep<3, 6>;
  using SpatialStep = CoreStep<6, 12>;

  PlanarStep planar_step(const NavState& mean, double dt, bool standing) const;
  SpatialStep spatial_step(const NavState& mean, double dt, bool standing) const;
  void predict_pose(NavState& mean, double dt) const;
  /// Means and covariance of the blocks.
  void predict_blocks(Belief& belief, double dt, bool standing) const;

  const StateLayout& layout_;
  ProcessNoise noise_;
};

}  // namespace waymark::estimation
