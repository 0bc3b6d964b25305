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

void WatchedSensor::clear_window() {
  yaw.clear();
  heading.clear();
  way.clear();
  sideways.clear();
  course.clear();
  ground_way.clear();
  velocity_east.clear();
  velocity_north.clear();
  force.clear();
  turn.clear();
  field.clear();
  height.clear();
  fixes.clear();
  steps.clear();
  scan_t = -1.0;
  next_scan_t = 0.0;
}

Eigen::Vector3d TurnedVector::by_turn() const {
  return {products(2, 1) - products(1, 2), products(0, 2) - products(2, 0), products(1, 0) - products(0, 1)};
}

std::optional<TurnedVector> turned_vector(const VectorTrack& turn, const VectorTrack& vector, double t,
                                          double half_window) {
  const auto steps = static_cast<int>(std::lround(kVectorSpan / Track::kStep));
  const auto before = vector.rate(t, half_window);
  const auto after = vector.rate(t + kVectorSpan, half_window);
  if (!before || !after) return std::nullopt;
  TurnedVector result{*after - *before, Eigen::Matrix3d::Zero(), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  for (int k = 0; k < steps; ++k) {
    const double from = t + k * Track::kStep;
    const auto turned = turn.change(from, from + Track::kStep);
    const auto summed = vector.change(from, from + Track::kStep);
    if (!turned || !summed) return std::nullopt;
    result.products += *turned * summed->transpose() / Track::kStep;
    result.sum += *summed;
    result.turn += *turned;
  }
  return result;
}

std::optional<TiltedField> tilted_field(const WatchedSensor& magnetometer, const WatchedSensor& imu, double t,
                                        double half_window) {
  const auto force = imu.force.rate(t, half_window);
  const auto field = magnetometer.field.rate(t, half_window);
  if (!force || !field) return std::nullopt;
  return TiltedField{force->head<2>() / kGravity, *field};
}

char axis_along(const WatchedSensor& sensor, const Eigen::Vector3d& base_axis) {
  Eigen::Index axis = 0;
  (sensor.T_base_sensor.q.conjugate() * base_axis).cwiseAbs().maxCoeff(&axis);
  return "xyz"[axis];
}

}  // namespace waymark::host::diagnosis
