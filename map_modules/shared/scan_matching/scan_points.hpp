// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "map_modules/shared/scan_matching/scan_settings.hpp"
#include "waymark/base/error.hpp"
#include "waymark/interface/map_module.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::scan_matching {

/// Calls hit(p_base) for the end points of a scan that are used, and clear(p_base) for where beams without return are
/// free up to [m], all in the base frame at the stamp: motion-compensated, if the beams have times of their
/// own. Throws DataError if there is none of either.
template <class Hit, class Clear>
void for_beams(const LaserScan& scan, const Pose& T_base_sensor, const MotionWindow& motion,
               const ScanSettings& settings, const Hit& hit, const Clear& clear) {
  bool is_used = false;
  for (std::size_t k = 0; k < scan.ranges_m.size(); ++k) {
    const auto range = static_cast<double>(scan.ranges_m[k]);
    const auto beam = static_cast<double>(k);
    const double bearing = scan.start_rad + beam * scan.step_rad;
    const auto at = [&](double r) -> Eigen::Vector3d {
      const Eigen::Vector3d p = T_base_sensor * Eigen::Vector3d(r * std::cos(bearing), r * std::sin(bearing), 0.0);
      return scan.beam_interval_s == 0.0 ? p : motion.relative(beam * scan.beam_interval_s) * p;
    };
    if (!(range >= settings.range_min)) continue;  // NaN, too
    if (range >= settings.no_return) {
      if (settings.no_return_clears <= 0.0) continue;
      clear(at(settings.no_return_clears));
      is_used = true;
    } else if (range <= settings.range_max) {
      hit(at(range));
      is_used = true;
    }
  }
  if (is_used) return;
  throw DataError("none of the scan's " + std::to_string(scan.ranges_m.size()) +
                  " beams lies between range_min_m and range_max_m");
}

/// The points of one scan in the base frame, in the plane (N = 2) or in space (N = 3), the same for all particles.
template <int N>
struct ScanPoints {
  using Point = Eigen::Matrix<double, N, 1>;
  using StoredPoint = Eigen::Matrix<float, N, 1>;

  Point p_base_sensor = Point::Zero();  ///< where all beams begin [m]
  std::vector<StoredPoint> hits;        ///< end points [m]
  std::vector<StoredPoint> clear_to;    ///< of beams without return: free up to there [m]
  double reach = 0.0;                   ///< of the points and the sensor from the base's origin, at most [m]
  /// Nothing but the scans measures the robot's motion: each is matched, however near the last one. Not on a
  /// checkpoint, since a map that is drawn again takes all.
  bool measures_motion = false;

  static constexpr double kMostReach = 2e3;  ///< of a checkpoint's scan [m]

  /// Reading throws DataError if a point lies beyond the reach.
  template <class Archive>
  void serialize(Archive& archive) {
    archive.section("scan_points", 1);
    const auto point = [](auto& each, StoredPoint& p) { each(p); };
    archive(p_base_sensor);
    archive.within(reach, 0.0, kMostReach);
    archive.each(hits, point);
    archive.each(clear_to, point);
    if constexpr (Archive::kReads) {
      const auto is_near = [this](const StoredPoint& p) { return p.template cast<double>().norm() <= reach + 1e-3; };
      if (!std::ranges::all_of(hits, is_near) || !std::ranges::all_of(clear_to, is_near))
        throw DataError("the checkpoint has a scan with points out of its reach");
    }
  }
};

/// The points of a planar scan that are used, motion-compensated (`for_beams`). Throws DataError if there is none, and
/// nothing that is free either.
template <int N>
ScanPoints<N> scan_points(const LaserScan& scan, const Pose& T_base_sensor, const MotionWindow& motion,
                          const ScanSettings& settings) {
  ScanPoints<N> points;
  points.p_base_sensor = T_base_sensor.p.template head<N>();
  points.reach = points.p_base_sensor.norm();
  points.hits.reserve(scan.ranges_m.size());
  const auto kept = [&](const Eigen::Vector3d& p_base) -> typename ScanPoints<N>::StoredPoint {
    const typename ScanPoints<N>::Point p = p_base.template head<N>();
    points.reach = std::max(points.reach, p.norm());
    return p.template cast<float>();
  };
  for_beams(
      scan, T_base_sensor, motion, settings, [&](const Eigen::Vector3d& p) { points.hits.push_back(kept(p)); },
      [&](const Eigen::Vector3d& p) { points.clear_to.push_back(kept(p)); });
  return points;
}

}  // namespace waymark::scan_matching
