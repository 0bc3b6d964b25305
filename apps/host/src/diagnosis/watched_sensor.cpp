// SPDX-License-Identifier: Apache-2.0
#include "watched_sensor.hpp"

#include <algorithm>
#include <cmath>

#include "waymark/interface/payloads.hpp"

namespace waymark::host::diagnosis {

void Thinned::add(double value) {
  if (!std::isfinite(value) || seen_++ % every_ != 0) return;
  if (values_.size() == kMost) {
    for (std::size_t k = 0; 2 * k < kMost; ++k) values_[k] = values_[2 * k];
    values_.resize(kMost / 2);
    every_ *= 2;
  }
  values_.push_back(value);
}

double Thinned::quantile(double share) const {
  if (values_.empty()) return 0.0;
  std::vector<double> sorted = values_;
  const auto at = sorted.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(sorted.size() - 1));
  std::ranges::nth_element(sorted, at);
  return *at;
}

Role WatchedSensor::role() const {
  if (payload == LaserScan::kType) return Role::scanner;
  if (way.samples() > 0) return Role::wheels;
  if (!fixes.empty() || course.samples() > 0) return Role::fix;
  if (has_heading) return Role::heading;
  if (yaw.samples() > 0) return Role::gyro;
  return Role::other;
}

bool WatchedSensor::is_altimeter() const { return std::isfinite(usual.height_m); }

void GravityTurns::clear() {
  for (auto& row : products) {
    for (Track& product : row) product.clear();
  }
}

void WatchedSensor::clear_window() {
  yaw.clear();
  heading.clear();
  way.clear();
  sideways.clear();
  course.clear();
  ground_way.clear();
  force_x.clear();
  force_y.clear();
  gravity_turns.clear();
  field_x.clear();
  field_y.clear();
  field_z.clear();
  height.clear();
  fixes.clear();
  steps.clear();
  scan_t = -1.0;
  next_scan_t = 0.0;
}

std::optional<GravityChange> gravity_change(const WatchedSensor& imu, double t, double half_window) {
  const double end = t + kGravitySpan;
  const auto x_before = imu.force_x.rate(t, half_window);
  const auto y_before = imu.force_y.rate(t, half_window);
  const auto x_after = imu.force_x.rate(end, half_window);
  const auto y_after = imu.force_y.rate(end, half_window);
  if (!x_before || !y_before || !x_after || !y_after) return std::nullopt;
  GravityChange result{{*x_after - *x_before, *y_after - *y_before}, Eigen::Matrix3d::Zero()};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      const auto product = imu.gravity_turns.products[i][j].change(t, end);
      if (!product) return std::nullopt;
      result.products(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = *product;
    }
  }
  return result;
}

std::optional<TiltedField> tilted_field(const WatchedSensor& magnetometer, const WatchedSensor& imu, double t,
                                        double half_window) {
  const auto f_x = imu.force_x.rate(t, half_window);
  const auto f_y = imu.force_y.rate(t, half_window);
  const auto m_x = magnetometer.field_x.rate(t, half_window);
  const auto m_y = magnetometer.field_y.rate(t, half_window);
  const auto m_z = magnetometer.field_z.rate(t, half_window);
  if (!f_x || !f_y || !m_x || !m_y || !m_z) return std::nullopt;
  return TiltedField{Eigen::Vector2d(*f_x, *f_y) / kGravity, {*m_x, *m_y, *m_z}};
}

char axis_along(const WatchedSensor& sensor, const Eigen::Vector3d& base_axis) {
  Eigen::Index axis = 0;
  (sensor.T_base_sensor.q.conjugate() * base_axis).cwiseAbs().maxCoeff(&axis);
  return "xyz"[axis];
}

}  // namespace waymark::host::diagnosis
