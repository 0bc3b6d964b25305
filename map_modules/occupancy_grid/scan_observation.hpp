// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>

#include "map_modules/shared/scan_matching/scan_points.hpp"
#include "map_modules/shared/scan_matching/scan_settings.hpp"
#include "waymark/interface/map_module.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::occupancy_grid {

/// One scan, seen from above.
struct ScanObservation final : Observation, scan_matching::ScanPoints<2> {
  ScanObservation() = default;
  explicit ScanObservation(scan_matching::ScanPoints<2> points) : ScanPoints(std::move(points)) {}
};

/// The points of a scan that are used. Throws DataError if there is none, and nothing that is free either.
ScanObservation observe(const LaserScan& scan, const Pose& T_base_sensor, const MotionWindow& motion,
                        const scan_matching::ScanSettings& settings);

}  // namespace waymark::occupancy_grid
