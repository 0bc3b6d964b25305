// SPDX-License-Identifier: Apache-2.0
#include "fix_position.hpp"

#include <GeographicLib/LocalCartesian.hpp>
#include <cmath>
#include <string>

#include "waymark/base/error.hpp"

namespace waymark::dgps {

void check_usable(const GnssFix& fix, int min_satellites) {
  if (fix.type == GnssFix::Type::none) throw DataError("the receiver reports no fix");
  if (fix.satellites >= 0 && fix.satellites < min_satellites)
    throw DataError("too few satellites: " + std::to_string(fix.satellites));
  if (!is_geodetic(fix)) return;
  if (!std::isfinite(fix.latitude_deg) || !std::isfinite(fix.longitude_deg))
    throw DataError("the fix has neither east and north nor latitude and longitude");
  if (fix.latitude_deg == 0.0 && fix.longitude_deg == 0.0)
    throw DataError("latitude 0, longitude 0: receivers write this without a fix");
  if (std::abs(fix.latitude_deg) > 90.0 || std::abs(fix.longitude_deg) > 180.0) {
    throw DataError("latitude " + std::to_string(fix.latitude_deg) + ", longitude " +
                    std::to_string(fix.longitude_deg) + " is not a place on Earth");
  }
}

Eigen::Vector3d position(const GnssFix& fix, const Datum* datum) {
  if (!is_geodetic(fix)) return fix.p_map_antenna;
  if (datum == nullptr) throw DataError("a geodetic fix needs a datum");
  const GeographicLib::LocalCartesian frame(datum->latitude_deg, datum->longitude_deg, datum->height_m);
  Eigen::Vector3d p;
  frame.Forward(fix.latitude_deg, fix.longitude_deg, std::isfinite(fix.height_m) ? fix.height_m : datum->height_m,
                p.x(), p.y(), p.z());
  if (!std::isfinite(fix.height_m)) p.z() = GnssFix::kUnknown;
  return p;
}

}  // namespace waymark::dgps
