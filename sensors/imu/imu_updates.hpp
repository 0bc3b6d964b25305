// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "waymark/interface/update.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::imu {

/// z = ω of the base [rad/s], all of it or, in the plane, its z component; that one with the bias out of the block, if
/// there is one.
class RateUpdate final : public Update {
 public:
  /// `R`: covariance in the base frame [rad²/s²]. `block_size`: 1 with the state of the z component's bias, else 0.
  RateUpdate(const Eigen::Vector3d& w_base, const Eigen::Matrix3d& R, bool planar, int block_size)
      : w_base_(w_base), R_(R), planar_(planar), block_size_(block_size) {}

  void linearize(const StateView& state, Linearization& out) const override {
    Eigen::Vector3d residual = w_base_ - state.nav.w_base;
    if (block_size_ > 0) residual.z() -= state.block[0];
    if (planar_) {
      out.reset(1, block_size_);
      out.residual(0) = residual.z();
      out.R(0, 0) = R_(2, 2);
      out.angular_rate()(0, 2) = 1.0;
    } else {
      out.reset(3, block_size_);
      out.residual = residual;
      out.R = R_;
      out.angular_rate() = Eigen::Matrix3d::Identity();
    }
    if (block_size_ > 0) out.block()(planar_ ? 0 : 2, 0) = 1.0;
  }

 private:
  Eigen::Vector3d w_base_;
  Eigen::Matrix3d R_;
  bool planar_;
  int block_size_;
};

/// z = the yaw bias [rad/s], as the cascade learnt it at rest.
class YawBiasUpdate final : public Update {
 public:
  YawBiasUpdate(double bias, double variance) : bias_(bias), variance_(variance) {}

  void linearize(const StateView& state, Linearization& out) const override {
    out.reset(1, 1);
    out.residual(0) = bias_ - state.block[0];
    out.R(0, 0) = variance_;
    out.block()(0, 0) = 1.0;
  }

 private:
  double bias_;
  double variance_;
};

/// Where up is in the base frame: with u = R u_base the residual is the x and y component of u × e_z, zero where R
/// agrees. No information about the heading. Those components vanish for a base on its head, too, and beyond 45° they
/// are taken for the rotation from u to e_z, which grows up to there.
class TiltUpdate final : public Update {
 public:
  /// `variance` of each of the two [rad²].
  TiltUpdate(const Eigen::Vector3d& up_base, double variance) : up_base_(up_base), variance_(variance) {}

  Quantity observes() const override { return Quantity::attitude; }
  void linearize(const StateView& state, Linearization& out) const override {
    const Eigen::Vector3d u = state.nav.T_map_base.q * up_base_;
    out.reset(2, 0);
    out.residual << u.y(), -u.x();
    out.R.diagonal().setConstant(variance_);
    if (u.z() < kCosOfFar) {
      // On its head exactly, any axis will do.
      if (out.residual.norm() < kLeastSine) out.residual << kLeastSine, 0.0;
      const double sine = out.residual.norm();
      const double grows = std::atan2(sine, u.z()) / sine;
      const Eigen::Vector2d axis = out.residual / sine;
      // A turn about the other axis turns this one, without bound where the base is on its head.
      const double across = std::max(grows * u.z(), -kMostAcross);
      const Eigen::Matrix2d tilt = across * Eigen::Matrix2d::Identity() + (1.0 - across) * (axis * axis.transpose());
      out.residual *= grows;
      out.attitude().leftCols<2>() = tilt;
      out.attitude().col(2) = -grows * u.head<2>();
      return;
    }
    out.attitude() << u.z(), 0.0, -u.x(), 0.0, u.z(), -u.y();
  }

 private:
  static constexpr double kCosOfFar = 0.7;
  static constexpr double kLeastSine = 1e-6;
  static constexpr double kMostAcross = 2.0;

  Eigen::Vector3d up_base_;
  double variance_;
};

/// z = R, the whole attitude of the base; the residual is the rotation vector from the state to it in the map frame.
class AttitudeUpdate final : public Update {
 public:
  /// `R`: covariance of the rotation vector in the map frame [rad²].
  AttitudeUpdate(const Eigen::Quaterniond& q_map_base, const Eigen::Matrix3d& R) : q_map_base_(q_map_base), R_(R) {}

  Quantity observes() const override { return Quantity::attitude; }
  void linearize(const StateView& state, Linearization& out) const override {
    const Eigen::Vector3d residual = so3::log(q_map_base_ * state.nav.T_map_base.q.conjugate());
    out.reset(3, 0);
    out.residual = residual;
    out.R = R_;
    out.attitude() = so3::left_jacobian(-residual).inverse();
  }

 private:
  Eigen::Quaterniond q_map_base_;
  Eigen::Matrix3d R_;
};

/// z = the heading of the base in the plane [rad].
class HeadingUpdate final : public Update {
 public:
  HeadingUpdate(double yaw, double variance) : yaw_(yaw), variance_(variance) {}

  Quantity observes() const override { return Quantity::attitude; }
  void linearize(const StateView& state, Linearization& out) const override {
    out.reset(1, 0);
    out.residual(0) = so3::wrap(yaw_ - state.nav.T_map_base.yaw());
    out.R(0, 0) = variance_;
    out.attitude()(0, 2) = 1.0;
  }

 private:
  double yaw_;
  double variance_;
};

}  // namespace waymark::imu
