// SPDX-License-Identifier: Apache-2.0
#include "twist.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "relative_pose.hpp"
#include "waymark/base/error.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::relative {
namespace {

/// As `RelativePose`, in the plane; σ are not known.
RelativePose in_space(const PoseIncrement& planar) {
  RelativePose motion;
  motion.interval_s = planar.interval_s;
  motion.p_m = {planar.x_m, planar.y_m, 0.0};
  motion.q = so3::from_rpy(0.0, 0.0, planar.yaw_rad);
  return motion;
}

RelativePose motion_of(const Measurement& measurement) {
  if (measurement.payload->type() == PoseIncrement::kType) return in_space(measurement.as<PoseIncrement>());
  return measurement.as<RelativePose>();
}

/// (v, ω) of the base by (v, ω) of a sensor at l with orientation R: ω_b = R ω, v_b = R v + l × ω_b.
Matrix6 adjoint(const Pose& T_base_sensor) {
  const Eigen::Matrix3d R = T_base_sensor.q.toRotationMatrix();
  Matrix6 Ad;
  Ad << R, so3::skew(T_base_sensor.p) * R, Eigen::Matrix3d::Zero(), R;
  return Ad;
}

double variance(double reported, double density, const IncrementNoise& noise, double interval) {
  return noise.use_reported && reported > 0.0 ? reported * reported : density * density * interval;
}

/// The parts of a twist: velocity and rate.
Eigen::Vector3d velocity_of(const Vector6& twist) { return twist.head<3>(); }
Eigen::Vector3d rate_of(const Vector6& twist) { return twist.tail<3>(); }

/// 3σ of the velocity, or of the rate, in its worst direction at most.
double three_sigma(const Matrix6& covariance, int first) {
  return 3.0 * std::sqrt(covariance.block<3, 3>(first, first).trace());
}

}  // namespace

Twist twist_of(const Measurement& measurement, const Pose& T_base_sensor, const IncrementNoise& noise) {
  const RelativePose motion = motion_of(measurement);
  const double dt = motion.interval_s;
  if (!(dt > 0.0)) throw DataError("an interval of " + std::to_string(dt) + " s; expected more than 0");
  Twist twist;
  twist.interval_s = dt;
  twist.tracked = motion.tracked;
  if (!motion.tracked) return twist;
  if (!motion.p_m.allFinite() || !(std::abs(motion.q.norm() - 1.0) < 1e-3))
    throw DataError("the motion of a track is not finite, or its orientation is no unit quaternion");
  const Eigen::Vector3d phi = so3::log(motion.q.normalized());
  Vector6 of_sensor;
  of_sensor << so3::left_jacobian(phi).inverse() * motion.p_m / dt, phi / dt;
  // The logarithm's Jacobian is that of small rotations, the identity.
  Vector6 variances;
  for (int i = 0; i < 3; ++i) {
    variances[i] = variance(motion.sigma_p_m[i], noise.position, noise, dt);
    variances[3 + i] = variance(motion.sigma_q_rad[i], noise.rotation, noise, dt);
  }
  const Matrix6 Ad = adjoint(T_base_sensor);
  twist.mean = Ad * of_sensor;
  twist.covariance = Ad * (variances / (dt * dt)).asDiagonal() * Ad.transpose();
  return twist;
}

bool Limits::allow(const Twist& twist) const {
  return twist.tracked && velocity_of(twist.mean).norm() <= speed + three_sigma(twist.covariance, 0) &&
         rate_of(twist.mean).norm() <= rate + three_sigma(twist.covariance, 3);
}

bool Limits::allow_change(const Twist& before, const Twist& twist, double elapsed) const {
  const Vector6 change = twist.mean - before.mean;
  const Matrix6 covariance = before.covariance + twist.covariance;
  return velocity_of(change).norm() <= acceleration * elapsed + three_sigma(covariance, 0) &&
         rate_of(change).norm() <= angular_acceleration * elapsed + three_sigma(covariance, 3);
}

Twist Limits::extrapolate(const Twist& before, double elapsed) const {
  Twist twist = before;
  const double dv = std::min(acceleration * elapsed, speed);
  const double dw = std::min(angular_acceleration * elapsed, rate);
  twist.covariance.diagonal().head<3>().array() += dv * dv;
  twist.covariance.diagonal().tail<3>().array() += dw * dw;
  return twist;
}

}  // namespace waymark::relative
