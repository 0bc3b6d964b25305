// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace waymark::imu {

/// The filter to compare with, written from its paper: S. Madgwick, A. Harrison, R. Vaidyanathan, "Estimation of IMU
/// and MARG orientation using a gradient descent algorithm", ICORR 2011. One normalised gradient step of size `beta`
/// [rad/s] per sample.
class Madgwick {
 public:
  explicit Madgwick(double beta) : beta_(beta) {}

  /// Rate [rad/s], specific force and field [any unit], time since the last sample [s]. The first sample sets the
  /// state.
  void process(const Eigen::Vector3d& w, const Eigen::Vector3d& f, const Eigen::Vector3d& m, double dt) {
    if (!started_) {
      const Eigen::Vector3d up = f.normalized();
      const Eigen::Vector3d west = f.cross(m).normalized();
      Eigen::Matrix3d R_sensor_earth;
      R_sensor_earth << west.cross(up), west, up;
      q_ = Eigen::Quaterniond(R_sensor_earth).conjugate();
      started_ = true;
    }
    const Eigen::Vector3d h = q_ * m.normalized();
    const Eigen::Vector3d field(h.head<2>().norm(), 0.0, h.z());
    const Eigen::Vector4d gradient =
        gradient_of(Eigen::Vector3d::UnitZ(), f.normalized()) + gradient_of(field, m.normalized());
    const Eigen::Quaterniond turning = q_ * Eigen::Quaterniond(0.0, w.x(), w.y(), w.z());
    const Eigen::Vector4d rate =
        0.5 * Eigen::Vector4d(turning.w(), turning.x(), turning.y(), turning.z()) - beta_ * gradient.normalized();
    q_.w() += rate(0) * dt;
    q_.vec() += rate.tail<3>() * dt;
    q_.normalize();
  }

  /// East-north-up: the filter's own world is north-west-up.
  Eigen::Quaterniond q_map_sensor() const {
    return Eigen::Quaterniond(Eigen::AngleAxisd(0.5 * std::numbers::pi, Eigen::Vector3d::UnitZ())) * q_;
  }

 private:
  /// Jᵀ (Rᵀ d − s) over (w, x, y, z), with d a direction of the world and s the same as measured.
  Eigen::Vector4d gradient_of(const Eigen::Vector3d& d, const Eigen::Vector3d& s) const {
    const double w = q_.w();
    const Eigen::Vector3d v = q_.vec();
    const Eigen::Vector3d residual = q_.conjugate() * d - s;
    // Rᵀ d = d + 2 v × (v × d) − 2 w v × d.
    const Eigen::Vector3d by_w = -2.0 * v.cross(d);
    Eigen::Matrix3d by_v;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d e = Eigen::Vector3d::Unit(k);
      by_v.col(k) = 2.0 * (e.cross(v.cross(d)) + v.cross(e.cross(d)) - w * e.cross(d));
    }
    Eigen::Vector4d gradient;
    gradient << by_w.dot(residual), by_v.transpose() * residual;
    return gradient;
  }

  double beta_;
  bool started_ = false;
  Eigen::Quaterniond q_ = Eigen::Quaterniond::Identity();
};

}  // namespace waymark::imu
