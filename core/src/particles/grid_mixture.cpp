// SPDX-License-Identifier: Apache-2.0
#include "particles/grid_mixture.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "waymark/base/error.hpp"

namespace waymark::particles {
namespace {

constexpr std::int64_t kMaxCells = 100'000'000;
constexpr int kHalf = 50;  // percent

/// A grid's lower left corner in cells of the first one.
struct Offset {
  std::int64_t x, y;
};

Offset offset_of(const GridView& grid, const GridView& first) {
  const Eigen::Vector3d apart = first.T_map_grid.q.inverse() * (grid.T_map_grid.p - first.T_map_grid.p);
  const Eigen::Vector2d cells = apart.head<2>() / first.resolution_m;
  const Eigen::Vector2d whole = cells.array().round();
  const double turned = first.T_map_grid.q.angularDistance(grid.T_map_grid.q);
  if (grid.resolution_m != first.resolution_m || !((cells - whole).cwiseAbs().maxCoeff() < 0.01) || !(turned < 1e-6))
    throw Error("grids of the particles of one map do not lie in one lattice");
  return {static_cast<std::int64_t>(whole.x()), static_cast<std::int64_t>(whole.y())};
}

std::uint8_t percent(double occupied, double known) {
  if (known <= 0.0) return GridView::kUnknown;
  if (occupied <= 0.0) return 0;
  if (occupied >= known) return 100;
  return static_cast<std::uint8_t>(std::clamp(std::lround(100.0 * occupied / known), 1L, 99L));
}

}  // namespace

std::optional<GridView> mix_grids(std::span<const WeightedGrid> grids) {
  if (grids.empty()) return std::nullopt;
  const GridView& first = grids.front().grid;
  std::vector<Offset> offsets;
  offsets.reserve(grids.size());
  Offset low{0, 0};
  Offset high{0, 0};
  for (const WeightedGrid& each : grids) {
    const Offset offset = offsets.emplace_back(offset_of(each.grid, first));
    low = {std::min(low.x, offset.x), std::min(low.y, offset.y)};
    high = {std::max(high.x, offset.x + each.grid.width), std::max(high.y, offset.y + each.grid.height)};
  }
  const std::int64_t width = high.x - low.x;
  const std::int64_t height = high.y - low.y;
  if (width * height > kMaxCells) throw Error("the maps of all particles together are too large for a picture");

  const auto count = static_cast<std::size_t>(width * height);
  std::vector<float> known(count, 0.0F);
  std::vector<float> occupied(count, 0.0F);
  for (std::size_t i = 0; i < grids.size(); ++i) {
    const GridView& grid = grids[i].grid;
    const auto weight = static_cast<float>(grids[i].weight);
    auto cell = grid.cells.begin();
    for (std::int64_t y = offsets[i].y - low.y; y < offsets[i].y - low.y + grid.height; ++y) {
      auto place = static_cast<std::size_t>(y * width + offsets[i].x - low.x);
      for (int x = 0; x < grid.width; ++x, ++cell, ++place) {
        if (*cell == GridView::kUnknown) continue;
        known[place] += weight;
        if (*cell > kHalf) occupied[place] += weight;
      }
    }
  }

  GridView mixture = {first.T_map_grid, first.resolution_m, static_cast<int>(width), static_cast<int>(height)};
  mixture.T_map_grid.p += first.T_map_grid.q * Eigen::Vector3d(static_cast<double>(low.x) * first.resolution_m,
                                                               static_cast<double>(low.y) * first.resolution_m, 0.0);
  mixture.cells.resize(count);
  // Equal weights in equal order: where all agree, both sums are equal to the last bit.
  for (std::size_t i = 0; i < count; ++i) mixture.cells[i] = percent(occupied[i], known[i]);
  return mixture;
}

}  // namespace waymark::particles
