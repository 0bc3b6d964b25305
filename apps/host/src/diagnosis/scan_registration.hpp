// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "waymark/interface/payloads.hpp"

namespace waymark::host::diagnosis {

/// Points of a planar scan in the order of its beams, thinned out; no map, no unit, no filter.
class ThinScan {
 public:
  static constexpr int kMost = 180;

  ThinScan();
  /// Takes the returns of a scan. A range within 2 % of the largest one so far is taken for a beam without return.
  /// False if too few are left.
  bool take(const LaserScan& scan, double& largest);

  struct Point {
    Eigen::Vector2d p;
    Eigen::Vector2d normal;  ///< of the surface; zero if its neighbours are not on one with it
    double bearing = 0.0;    ///< from that of the first beam on, always growing
  };
  const std::vector<Point>& points() const { return points_; }
  double median_range() const { return median_; }

 private:
  std::vector<Point> points_;
  std::vector<double> ranges_;
  double median_ = 0.0;
};

/// Motion of a scanner between two scans, in its own plane: pose of the second in the frame of the first.
struct ScanMotion {
  double x = 0.0;  ///< in the unit of the ranges
  double y = 0.0;
  double yaw = 0.0;                                      ///< [rad]
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of (x, y, yaw)
  bool is_shift_known = false;                           ///< false in a corridor: along it the shift is a guess
  double inliers = 0.0;                                  ///< share of the points
};

/// Registers two scans by iterated closest points, point to line (A. Censi, ICRA 2008, with the closest point sought
/// among the neighbouring bearings), first at several angles. Nothing if they do not fit together.
std::optional<ScanMotion> register_scans(const ThinScan& first, const ThinScan& second);

}  // namespace waymark::host::diagnosis
