// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "beacons.hpp"
#include "range_update.hpp"

namespace waymark::indoor_gps {

/// At most so many ranges are used for one position.
inline constexpr int kMaxRanges = 24;

/// A position in the plane out of ranges alone.
struct RangedPosition {
  Eigen::Vector2d p_map_antenna;  ///< [m]
  double sigma;                   ///< per axis, in its worst direction [m]
  double slow_sigma;              ///< the part of it that scale and offset make, which later positions have as well
};

/// Position of the antenna at height `z_map` from ranges to three beacons or more, taken at once: weighted least
/// squares by Gauss–Newton from every intersection of two circles. Scale and offset are not known: their first σ is
/// part of the noise, as errors that the ranges have in common. Nothing if there is more than one solution (beacons in
/// a line), if the ranges contradict each other, or if the position is so uncertain that a linear filter could not go
/// on from it.
std::optional<RangedPosition> multilaterate(const Beacons& beacons, std::span<const RangeRow> ranges, double z_map);

}  // namespace waymark::indoor_gps
