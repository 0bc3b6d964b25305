// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

#include "ego_velocity.hpp"
#include "waymark/interface/update.hpp"
#include "waymark/math/pose.hpp"

namespace waymark::radar {

/// Places of the sensor's own states within its block; −1: no state.
struct BlockIndex {
  int size = 0;
  int mounting_yaw = -1;
  int speed_scale = -1;
  int slip = -1;
};

/// The velocity of a radar: z = (1 + s) R_mᵀ Rz(−β) (v + ω × l), with the mounting R_m at l in the base frame, the
/// error β of its yaw, counter-clockwise about the base's z axis, and the scale error s of its speed. Rows: x, y, and z
/// with three dimensions.
class VelocityUpdate : public Update {
 public:
  VelocityUpdate(const Eigen::Vector3d& z, const Eigen::Matrix3d& R, int dimensions, const Pose& T_base_sensor,
                 const BlockIndex& index)
      : z_(z), R_(R), dimensions_(dimensions), q_(T_base_sensor.q), l_(T_base_sensor.p), index_(index) {}

  void linearize(const StateView& state, Linearization& out) const override {
    const double yaw = index_.mounting_yaw < 0 ? 0.0 : state.block[index_.mounting_yaw];
    const Eigen::AngleAxisd turned(yaw, Eigen::Vector3d::UnitZ());
    const double scale = index_.speed_scale < 0 ? 1.0 : 1.0 + state.block[index_.speed_scale];
    const Eigen::Matrix3d to_sensor = scale * (turned * q_).toRotationMatrix().transpose();
    const Eigen::Vector3d v_base = state.nav.v_base + state.nav.w_base.cross(l_);
    out.reset(dimensions_, index_.size);
    out.residual = (z_ - to_sensor * v_base).head(dimensions_);
    out.R = R_.topLeftCorner(dimensions_, dimensions_);
    out.velocity() = to_sensor.topRows(dimensions_);
    out.angular_rate() = (-to_sensor * so3::skew(l_)).topRows(dimensions_);
    if (index_.mounting_yaw >= 0) {
      const Eigen::Vector3d by_yaw = -(to_sensor * Eigen::Vector3d::UnitZ().cross(v_base));
      out.block().col(index_.mounting_yaw) = by_yaw.head(dimensions_);
    }
    if (index_.speed_scale >= 0) {
      const Eigen::Vector3d by_scale = to_sensor * v_base / scale;
      out.block().col(index_.speed_scale) = by_scale.head(dimensions_);
    }
  }
  Quantity observes() const override { return Quantity::velocity; }

 private:
  Eigen::Vector3d z_;
  Eigen::Matrix3d R_;
  int dimensions_;
  Eigen::Quaterniond q_;
  Eigen::Vector3d l_;
  BlockIndex index_;
};

/// The rear axle, the base's origin, does not move sideways but for the slip angle k a of its tyres under the lateral
/// acceleration a = v_x ω: 0 = v_y + k v_x² ω (linear tyres; M. Mitschke, "Dynamik der Kraftfahrzeuge").
class RearAxleUpdate : public Update {
 public:
  RearAxleUpdate(double variance, double slip, const BlockIndex& index)
      : variance_(variance), slip_(slip), index_(index) {}

  void linearize(const StateView& state, Linearization& out) const override {
    const double k = index_.slip < 0 ? slip_ : state.block[index_.slip];
    const double v_x = state.nav.v_base.x();
    const double w_z = state.nav.w_base.z();
    out.reset(1, index_.size);
    out.residual(0) = -(state.nav.v_base.y() + k * v_x * v_x * w_z);
    out.R(0, 0) = variance_;
    out.velocity()(0, 0) = 2.0 * k * v_x * w_z;
    out.velocity()(0, 1) = 1.0;
    out.angular_rate()(0, 2) = k * v_x * v_x;
    if (index_.slip >= 0) out.block()(0, index_.slip) = v_x * v_x * w_z;
  }
  Quantity observes() const override { return Quantity::velocity; }

 private:
  double variance_;  ///< [m²/s²]
  double slip_;      ///< k [rad s²/m], where it is no state
  BlockIndex index_;
};

}  // namespace waymark::radar
