// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "waymark/interface/update.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::dgps {

/// A position fix of the antenna: z = p + R l + k b, with lever arm l and, if there is one, the slowly varying offset b
/// out of the block. k: how much larger the slow error of this fix is than that of a usual one.
class PositionUpdate final : public Update {
 public:
  PositionUpdate(const Eigen::Vector3d& p_map_antenna, const Eigen::Vector3d& lever_arm,
                 const Eigen::Vector3d& variance, int rows, int block_size, double offset_scale = 1.0)
      : z_(p_map_antenna),
        arm_(lever_arm),
        variance_(variance),
        rows_(rows),
        block_size_(block_size),
        offset_scale_(offset_scale) {}

  Quantity observes() const override { return Quantity::position; }
  void linearize(const StateView& state, Linearization& out) const override {
    out.reset(rows_, block_size_);
    const Eigen::Vector3d arm = state.nav.T_map_base.q * arm_;
    Eigen::Vector3d residual = z_ - state.nav.T_map_base.p - arm;
    for (int i = 0; i < std::min(block_size_, rows_); ++i) residual[i] -= offset_scale_ * state.block[i];
    out.residual = residual.head(rows_);
    out.R.diagonal() = variance_.head(rows_);
    out.position() = Eigen::Matrix3d::Identity().topRows(rows_);
    if (!arm_.isZero(0.0)) out.attitude() = -so3::skew(arm).topRows(rows_);
    for (int i = 0; i < std::min(block_size_, rows_); ++i) out.block()(i, i) = offset_scale_;
  }

 private:
  Eigen::Vector3d z_;
  Eigen::Vector3d arm_;
  Eigen::Vector3d variance_;
  int rows_;
  int block_size_;
  double offset_scale_;
};

/// The antenna's velocity over ground out of speed and course: z = (R (v + ω × l))_xy.
class VelocityUpdate final : public Update {
 public:
  /// `course`: clockwise from north [rad]; the noise along it is `sigma` [m/s], across it `sigma` and
  /// speed × `course_sigma` [rad].
  VelocityUpdate(double speed, double course, double sigma, double course_sigma, const Eigen::Vector3d& lever_arm,
                 int block_size)
      : arm_(lever_arm), block_size_(block_size) {
    const Eigen::Vector2d along(std::sin(course), std::cos(course));
    const Eigen::Vector2d across(along.y(), -along.x());
    const double variance_across = sigma * sigma + speed * speed * course_sigma * course_sigma;
    z_ = speed * along;
    R_ = sigma * sigma * along * along.transpose() + variance_across * across * across.transpose();
  }

  Quantity observes() const override { return Quantity::velocity; }
  void linearize(const StateView& state, Linearization& out) const override {
    out.reset(2, block_size_);
    const Eigen::Matrix3d R_map_base = state.nav.T_map_base.q.toRotationMatrix();
    const Eigen::Vector3d v_map = R_map_base * (state.nav.v_base + state.nav.w_base.cross(arm_));
    out.residual = z_ - v_map.head<2>();
    out.R = R_;
    out.attitude() = -so3::skew(v_map).topRows<2>();
    out.velocity() = R_map_base.topRows<2>();
    if (!arm_.isZero(0.0)) out.angular_rate() = -(R_map_base * so3::skew(arm_)).topRows<2>();
  }

 private:
  Eigen::Vector2d z_;
  Eigen::Matrix2d R_;
  Eigen::Vector3d arm_;
  int block_size_;
};

/// A robot on wheels does not go sideways: 0 = v_y of the base. With it the course observes the heading of a robot
/// that has no odometry.
class SideslipUpdate final : public Update {
 public:
  SideslipUpdate(double sigma, int block_size) : sigma_(sigma), block_size_(block_size) {}

  Quantity observes() const override { return Quantity::velocity; }
  void linearize(const StateView& state, Linearization& out) const override {
    out.reset(1, block_size_);
    out.residual(0) = -state.nav.v_base.y();
    out.R(0, 0) = sigma_ * sigma_;
    out.velocity()(0, 1) = 1.0;
  }

 private:
  double sigma_;
  int block_size_;
};

}  // namespace waymark::dgps
