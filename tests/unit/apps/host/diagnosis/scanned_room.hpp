// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "waymark/interface/payloads.hpp"

namespace waymark::host {

/// A room of 8 m × 6 m around the origin, with a box in a corner, seen from a pose.
inline LaserScan scan_from(double x, double y, double yaw, double step_deg) {
  LaserScan scan;
  scan.step_rad = step_deg * M_PI / 180.0;
  scan.start_rad = step_deg > 0.0 ? -M_PI / 2.0 : M_PI / 2.0;
  for (int k = 0; k < 181; ++k) {
    const double angle = yaw + scan.start_rad + k * scan.step_rad;
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    double range = 1e9;
    const auto wall = [&](double distance, double along) {
      if (along > 1e-9) range = std::min(range, distance / along);
    };
    wall(5.0 - x, c);
    wall(3.0 + x, -c);
    wall(3.5 - y, s);
    wall(2.5 + y, -s);
    const double to_box = (3.0 - x) / std::max(c, 1e-9);
    const double at = y + to_box * s;
    if (c > 0.0 && at > 1.5 && at < 3.5) range = std::min(range, to_box);
    scan.ranges_m.push_back(static_cast<float>(range));
  }
  return scan;
}

}  // namespace waymark::host
