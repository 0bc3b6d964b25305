// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/calibration/scan_pairs.hpp"

#include <utility>

namespace waymark::calibration {

namespace {

constexpr double kPairSeconds = 0.25;
constexpr double kLongestPair = 1.6;

}  // namespace

void ScanPairs::take(double t, const LaserScan& scan) {
  // Beams with times of their own: the scan stands for its middle.
  t += 0.5 * scan.beam_interval_s * static_cast<double>(scan.ranges_m.size());
  if (has_first_ && (t - first_t_ > kLongestPair || t <= first_t_)) has_first_ = false;
  if (!has_first_) {
    has_first_ = first_.take(scan, largest_range_);
    first_t_ = t;
    return;
  }
  if (t - first_t_ < kPairSeconds || !second_.take(scan, largest_range_)) return;
  if (const auto motion = host::diagnosis::register_scans(first_, second_)) {
    const Eigen::Matrix3d R = T_base_sensor_.q.toRotationMatrix();
    // A scanner upside down turns the other way round.
    Eigen::Matrix3d B = Eigen::Matrix3d::Zero();
    B.topLeftCorner<2, 2>() = R.topLeftCorner<2, 2>();
    B(2, 2) = R(2, 2) >= 0.0 ? 1.0 : -1.0;
    Eigen::Matrix3d covariance = B * motion->covariance * B.transpose();
    motions_.push_back({first_t_, t, B * Eigen::Vector3d(motion->x, motion->y, motion->yaw), covariance});
  }
  std::swap(first_, second_);
  first_t_ = t;
}

}  // namespace waymark::calibration
