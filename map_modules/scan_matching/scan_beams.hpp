// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <string>

#include "scan_settings.hpp"
#include "waymark/error.hpp"
#include "waymark/payloads.hpp"

namespace waymark::grid {

/// Calls hit(p_sensor) for the end points of a scan that are used, and clear(p_sensor) for where beams without return
/// say that it is free up to [m]. Throws DataError if there is none of either.
template <class Hit, class Clear>
void for_beams(const LaserScan& scan, const ScanSettings& settings, const Hit& hit, const Clear& clear) {
  bool is_used = false;
  for (std::size_t k = 0; k < scan.ranges_m.size(); ++k) {
    const auto range = static_cast<double>(scan.ranges_m[k]);
    const double bearing = scan.start_rad + static_cast<double>(k) * scan.step_rad;
    const auto at = [&](double r) { return Eigen::Vector3d(r * std::cos(bearing), r * std::sin(bearing), 0.0); };
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
