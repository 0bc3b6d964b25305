// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "waymark/interface/map_view.hpp"

namespace waymark::map_formats {

/// The rectangle of cells that a map fills, seen from above, and the picture of it. Cells count from the map's origin.
class GridExtent {
 public:
  /// `side` × `side` cells from this one on.
  void add(std::int32_t x, std::int32_t y, std::int32_t side = 1) {
    low_x_ = std::min(low_x_, x);
    low_y_ = std::min(low_y_, y);
    high_x_ = std::max(high_x_, x + side - 1);
    high_y_ = std::max(high_y_, y + side - 1);
  }
  bool empty() const { return low_x_ > high_x_; }

  /// Cells of the rectangle; it is not empty.
  std::int64_t cells() const { return (std::int64_t{high_x_} - low_x_ + 1) * (std::int64_t{high_y_} - low_y_ + 1); }
  /// A picture in which nothing is known yet. Throws Error if it were too large.
  GridView unknown(double resolution_m) const;
  /// Where a cell stands in the picture's `cells`.
  std::size_t place(std::int32_t x, std::int32_t y) const {
    const std::int64_t width = std::int64_t{high_x_} - low_x_ + 1;
    return static_cast<std::size_t>((std::int64_t{y} - low_y_) * width + (x - low_x_));
  }

 private:
  std::int32_t low_x_ = std::numeric_limits<std::int32_t>::max();
  std::int32_t low_y_ = std::numeric_limits<std::int32_t>::max();
  std::int32_t high_x_ = -std::numeric_limits<std::int32_t>::max();
  std::int32_t high_y_ = -std::numeric_limits<std::int32_t>::max();
};

}  // namespace waymark::map_formats
