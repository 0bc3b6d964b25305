// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "picture.hpp"

namespace waymark::plot {

/// Where the map's origin is on the Earth (WGS-84).
struct Origin {
  double latitude_deg;
  double longitude_deg;
};

/// Turns all of the content from the map (local east, north) to UTM (GeographicLib's UTMUPS, the origin's zone),
/// relative to the origin, and its axes to UTM. Over a map of less than 100 km covariances and headings turn as at the
/// origin.
void to_utm(Content& content, const Origin& origin);

}  // namespace waymark::plot
