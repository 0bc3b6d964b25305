// SPDX-License-Identifier: Apache-2.0
#include "map_modules/shared/scan_matching/cell.hpp"

#include <fmt/format.h>

#include <cmath>

#include "waymark/base/error.hpp"

namespace waymark::scan_matching {

TileRect TileRect::around(const Eigen::Vector2d& low, const Eigen::Vector2d& high, double side) {
  const Eigen::Vector2d first = low / side;
  const Eigen::Vector2d last = high / side;
  constexpr double kMost = TileIndex::kMost;
  if (!(first.minCoeff() > -kMost && last.maxCoeff() < kMost)) {  // NaN, too
    throw Error("the scan lies outside of what a grid can hold");
  }
  const auto index = [](double tiles) { return static_cast<std::int32_t>(std::floor(tiles)); };
  return {{index(first.x()), index(first.y())}, {index(last.x()), index(last.y())}};
}

void require_resolution(double found, double expected) {
  if (found == expected) return;
  throw DataError(fmt::format("checkpoint: the map has cells of {} m, but resolution_m is {}", found, expected));
}

}  // namespace waymark::scan_matching
