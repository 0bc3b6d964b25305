// SPDX-License-Identifier: Apache-2.0
#include "waymark/math/so3.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace waymark::so3 {
namespace {

/// Below this squared angle the closed forms lose digits; the series of four terms does not.
constexpr double kSmallSquaredAngle = 0.01;

/// The coefficients of J_l = I + b [theta]x + c [theta]x², and their derivatives by theta, divided by theta.
struct Coefficients {
  double b;
  double c;
  double db;
  double dc;
};

Coefficients coefficients(double s) {  // s: squared angle
  if (s < kSmallSquaredAngle) {
    return {1.0 / 2 - s * (1.0 / 24 - s * (1.0 / 720 - s / 40320)),
            1.0 / 6 - s * (1.0 / 120 - s * (1.0 / 5040 - s / 362880)),
            -1.0 / 12 + s * (1.0 / 180 - s * (1.0 / 6720 - s / 453600)),
            -1.0 / 60 + s * (1.0 / 1260 - s * (1.0 / 60480 - s / 4989600))};
  }
  const double angle = std::sqrt(s);
  const double sine = std::sin(angle);
  const double half_sine = std::sin(0.5 * angle);
  const double one_minus_cosine = 2.0 * half_sine * half_sine;
  return {one_minus_cosine / s, (angle - sine) / (s * angle), (angle * sine - 2.0 * one_minus_cosine) / (s * s),
          (one_minus_cosine - 3.0 * (angle - sine) / angle) / (s * s)};
}

}  // namespace

Eigen::Matrix3d skew(const Eigen::Vector3d& a) {
  Eigen::Matrix3d m;
  m << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return m;
}

Eigen::Quaterniond exp(const Eigen::Vector3d& theta) {
  const double angle = theta.norm();
  const double scale = angle < 1e-4 ? 0.5 - angle * angle / 48.0 : std::sin(0.5 * angle) / angle;
  Eigen::Quaterniond q(std::cos(0.5 * angle), scale * theta.x(), scale * theta.y(), scale * theta.z());
  q.normalize();
  return q;
}

Eigen::Vector3d log(const Eigen::Quaterniond& q) {
  // q and -q are the same rotation; w >= 0 picks the shorter way.
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;
  const Eigen::Vector3d v = sign * q.vec();
  const double w = sign * q.w();
  const double sine = v.norm();
  const double scale = sine < 1e-5 ? 2.0 / w * (1.0 - sine * sine / (3.0 * w * w)) : 2.0 * std::atan2(sine, w) / sine;
  return scale * v;
}

Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& theta) {
  const Coefficients k = coefficients(theta.squaredNorm());
  const Eigen::Matrix3d cross = skew(theta);
  return Eigen::Matrix3d::Identity() + k.b * cross + k.c * cross * cross;
}

Eigen::Matrix3d left_jacobian_times_vector_derivative(const Eigen::Vector3d& theta, const Eigen::Vector3d& a) {
  const Coefficients k = coefficients(theta.squaredNorm());
  const Eigen::Vector3d once = theta.cross(a);
  const Eigen::Vector3d twice = theta.cross(once);
  // theta × (theta × a) = theta (theta·a) - a |theta|²
  const Eigen::Matrix3d d_twice =
      theta.dot(a) * Eigen::Matrix3d::Identity() + theta * a.transpose() - 2.0 * a * theta.transpose();
  return -k.b * skew(a) + k.c * d_twice + (k.db * once + k.dc * twice) * theta.transpose();
}

double yaw(const Eigen::Quaterniond& q) {
  return wrap(std::atan2(2.0 * (q.w() * q.z() + q.x() * q.y()), 1.0 - 2.0 * (q.y() * q.y() + q.z() * q.z())));
}

Eigen::Quaterniond from_rpy(double roll, double pitch, double yaw) {
  return Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX());
}

Eigen::Vector3d to_rpy(const Eigen::Quaterniond& q) {
  const Eigen::Matrix3d R = q.toRotationMatrix();
  const double cos_pitch = std::hypot(R(0, 0), R(1, 0));
  const double pitch = std::atan2(-R(2, 0), cos_pitch);
  // At a pitch of ±90° roll and yaw rotate about the same axis; all of it is yaw.
  if (cos_pitch < 1e-9) return {0.0, pitch, std::atan2(-R(0, 1), R(1, 1))};
  return {std::atan2(R(2, 1), R(2, 2)), pitch, std::atan2(R(1, 0), R(0, 0))};
}

double wrap(double angle) {
  const double wrapped = std::remainder(angle, 2.0 * std::numbers::pi);
  return wrapped <= -std::numbers::pi ? std::numbers::pi : wrapped;
}

}  // namespace waymark::so3
