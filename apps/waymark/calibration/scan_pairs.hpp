// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "apps/host/src/diagnosis/scan_registration.hpp"
#include "apps/waymark/calibration/recording.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/math/pose.hpp"

namespace waymark::calibration {

/// Motions of a scanner, from pairs of its scans that follow each other at a quarter of a second or more.
class ScanPairs {
 public:
  explicit ScanPairs(const Pose& T_base_sensor) : T_base_sensor_(T_base_sensor) {}

  /// A scan at t [s], in order of time. Every second scan of a pair is the first of the next one.
  void take(double t, const LaserScan& scan);
  const std::vector<Scanner::Motion>& motions() const { return motions_; }
  Eigen::Vector2d lever() const { return T_base_sensor_.p.head<2>(); }

 private:
  Pose T_base_sensor_;
  host::diagnosis::ThinScan first_;
  host::diagnosis::ThinScan second_;
  double first_t_ = 0.0;
  bool has_first_ = false;
  double largest_range_ = 0.0;
  std::vector<Scanner::Motion> motions_;
};

}  // namespace waymark::calibration
