// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <string>

#include "scan_settings.hpp"
#include "waymark/base/error.hpp"
#include "waymark/interface/map_module.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::grid {

/// Calls hit(p_base) for the end points of a scan that are used, and clear(p_base) for where beams without return say
/// that it is free up to [m], all as seen from the base at the stamp: beams that were measured later are taken back
/// there. Throws DataError if there is none of either.
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

}  // namespace waymark::grid
