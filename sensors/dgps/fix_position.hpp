// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "waymark/interface/payloads.hpp"
#include "waymark/interface/sensor.hpp"

namespace waymark::dgps {

/// Throws DataError if the fix has no usable position: none reported, fewer satellites than `min_satellites`, no place
/// on Earth.
void check_usable(const GnssFix& fix, int min_satellites);

/// True if only latitude and longitude give the position of the antenna.
inline bool is_geodetic(const GnssFix& fix) { return !fix.p_map_antenna.head<2>().allFinite(); }

/// The antenna in the map: east, north, up from the datum [m]; up is NaN if the fix has no height. Throws DataError if
/// a geodetic fix comes without datum.
Eigen::Vector3d position(const GnssFix& fix, const Datum* datum);

}  // namespace waymark::dgps
