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
  force_x.clear();
  force_y.clear();
  height.clear();
  fixes.clear();
  steps.clear();
  scan_t = -1.0;
  next_scan_t = 0.0;
}

}  // namespace waymark::host::diagnosis
