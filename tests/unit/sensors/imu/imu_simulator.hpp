// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <sstream>
#include <string>

#include "attitude_filter.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::imu {

constexpr double kDegree = AttitudeSettings::kDegree;
constexpr double kGravity = 9.81;

/// What one sensor that turns and moves would measure. Time runs in steps of `dt`; between two samples the rate changes
/// linearly, which the simulated attitude follows in finer steps.
struct ImuSimulator {
  double dt = 0.01;  // [s]
  Eigen::Quaterniond q_map_sensor = Eigen::Quaterniond::Identity();
  std::function<Eigen::Vector3d(double)> rate = [](double) { return Eigen::Vector3d::Zero().eval(); };
  std::function<Eigen::Vector3d(double)> acceleration = [](double) { return Eigen::Vector3d::Zero().eval(); };
  std::function<Eigen::Vector3d(double)> field = [](double) { return Eigen::Vector3d(0.0, 20e-6, -45e-6); };
  Eigen::Vector3d bias = Eigen::Vector3d::Zero();
  double gyro_sigma = 0.0;   // [rad/s]
  double force_sigma = 0.0;  // [m/s²]
  double field_sigma = 0.0;  // [T]
  bool has_force = true;
  bool has_field = true;
  double range = 1e9;  // of the gyro [rad/s]

  double t = 0.0;
  std::mt19937_64 random{1};

  Time stamp() const { return Time{from_seconds(1000.0 + t)}; }

  /// The sample now.
  ImuSample sample() {
    ImuSample s;
    s.w_sensor = (rate(t) + bias + noise(gyro_sigma)).cwiseMax(-range).cwiseMin(range);
    if (has_force) {
      s.f_sensor =
          q_map_sensor.conjugate() * (acceleration(t) + Eigen::Vector3d(0.0, 0.0, kGravity)) + noise(force_sigma);
    }
    if (has_field) s.m_sensor = q_map_sensor.conjugate() * field(t) + noise(field_sigma);
    return s;
  }

  void advance() {
    constexpr int kSteps = 10;
    const double h = dt / kSteps;
    for (int i = 0; i < kSteps; ++i) {
      q_map_sensor = (q_map_sensor * so3::exp(rate(t + (i + 0.5) * h) * h)).normalized();
    }
    t += dt;
  }

  /// Feeds the filter for `seconds`; `look` sees filter and truth after each sample.
  void run(
      AttitudeFilter& filter, double seconds, const std::function<void()>& look = [] {}) {
    const double end = t + seconds;
    while (t < end - 0.5 * dt) {
      filter.process(stamp(), sample());
      look();
      advance();
    }
  }

 private:
  Eigen::Vector3d noise(double sigma) {
    std::normal_distribution<double> normal(0.0, 1.0);
    const double x = normal(random);
    const double y = normal(random);
    return sigma * Eigen::Vector3d(x, y, normal(random));
  }
};

/// The error as a rotation vector in the map frame, estimate to truth [rad].
inline Eigen::Vector3d error_of(const AttitudeFilter& filter, const ImuSimulator& truth) {
  return so3::log(truth.q_map_sensor * filter.q_map_sensor().conjugate());
}
inline double tilt_error(const AttitudeFilter& filter, const ImuSimulator& truth) {
  return error_of(filter, truth).head<2>().norm();
}

/// Turns about all axes, now this way, now that, up to about 1.5 rad/s per axis.
inline Eigen::Vector3d waving(double t) {
  return {1.5 * std::sin(1.1 * t), 1.2 * std::sin(0.7 * t + 1.0), 1.4 * std::sin(0.9 * t + 2.0)};
}

inline std::string bytes_of(const AttitudeFilter& filter) {
  std::ostringstream stream;
  OutArchive out(stream);
  out(filter);
  return stream.str();
}

}  // namespace waymark::imu
