// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "waymark/interface/update.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::compass {

/// Heading of the horizontal part of a vector, counter-clockwise from the map's x axis [rad].
inline double heading_of(const Eigen::Vector3d& v_map) { return std::atan2(v_map.y(), v_map.x()); }

/// A direction fixed in the base (the compass' x axis, or the field as it was measured) whose heading in the map is
/// known: z = heading of (R u)_xy, plus the slowly varying offset b out of the block if there is one. Roll and pitch
/// are those of the state, so tilt compensation and its uncertainty come with it.
class DirectionUpdate final : public Update {
 public:
  DirectionUpdate(const Eigen::Vector3d& u_base, double heading, double variance, int block_size)
      : u_base_(u_base), heading_(heading), variance_(variance), block_size_(block_size) {}

  Quantity observes() const override { return Quantity::attitude; }
  void linearize(const StateView& state, Linearization& out) const override {
    const Eigen::Vector3d u = state.nav.T_map_base.q * u_base_;
    const double horizontal2 = std::max(u.head<2>().squaredNorm(), kVertical * u.squaredNorm());
    out.reset(1, block_size_);
    out.residual(0) = so3::wrap(heading_ - heading_of(u) - (block_size_ > 0 ? state.block[0] : 0.0));
    out.R(0, 0) = variance_;
    out.attitude() << -u.x() * u.z() / horizontal2, -u.y() * u.z() / horizontal2, 1.0;
    if (block_size_ > 0) out.block()(0, 0) = 1.0;
  }

 private:
  static constexpr double kVertical = 1e-8;  // what points straight up has no heading: the Jacobian stays finite

  Eigen::Vector3d u_base_;
  double heading_;
  double variance_;
  int block_size_;
};

}  // namespace waymark::compass
