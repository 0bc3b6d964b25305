// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/map_formats/grid_extent.hpp"

#include <fmt/format.h>

#include "waymark/base/error.hpp"

namespace waymark::map_formats {

namespace {

constexpr std::int64_t kMostCells = std::int64_t{1} << 30;

}  // namespace

GridView GridExtent::unknown(double resolution_m) const {
  const std::int64_t width = std::int64_t{high_x_} - low_x_ + 1;
  const std::int64_t height = std::int64_t{high_y_} - low_y_ + 1;
  if (width > kMostCells / height) {
    throw Error(
        fmt::format("a picture of {} x {} cells is too large; at most {} are expected", width, height, kMostCells));
  }
  GridView view;
  view.T_map_grid = Pose::planar(low_x_ * resolution_m, low_y_ * resolution_m, 0.0);
  view.resolution_m = resolution_m;
  view.width = static_cast<int>(width);
  view.height = static_cast<int>(height);
  view.cells.assign(static_cast<std::size_t>(width * height), GridView::kUnknown);
  return view;
}

}  // namespace waymark::map_formats
