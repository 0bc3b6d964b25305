// SPDX-License-Identifier: Apache-2.0
#include "grid_view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "waymark/error.hpp"

namespace waymark::grid {

namespace {

constexpr std::int64_t kMostCells = std::int64_t{1} << 30;

double entropy_bit(double p) { return -(p * std::log2(p) + (1.0 - p) * std::log2(1.0 - p)); }

/// What a stored value means, for all of them.
template <class T, class Of>
std::array<T, 256> table_of(const Of& of) {
  std::array<T, 256> table{};
  for (int odds = -127; odds <= 127; ++odds)
    table[static_cast<std::uint8_t>(odds)] = of(Tile::probability(static_cast<std::int8_t>(odds)));
  return table;
}

}  // namespace

GridFigures figures_of(const TileTree& tiles) {
  static const auto entropies = table_of<double>(entropy_bit);
  GridFigures figures;
  double entropy = 0.0;
  tiles.for_all([&](TileIndex, const Tile& tile, bool is_shared) {
    ++figures.tiles;
    figures.tiles_shared += is_shared;
    for (const std::int8_t odds : tile.odds) {
      if (!Tile::is_known(odds)) continue;
      ++(Tile::is_occupied(odds) ? figures.occupied : figures.free);
      entropy += entropies[static_cast<std::uint8_t>(odds)];
    }
  });
  const std::size_t known = figures.occupied + figures.free;
  if (known > 0) figures.mean_entropy_bit = entropy / static_cast<double>(known);
  return figures;
}

std::optional<GridView> view_of(const TileTree& tiles, double resolution) {
  static const auto percent =
      table_of<std::uint8_t>([](double p) { return static_cast<std::uint8_t>(std::lround(100.0 * p)); });
  constexpr std::int32_t kMost = std::numeric_limits<std::int32_t>::max();
  Cell low{kMost, kMost};
  Cell high{-kMost, -kMost};
  const auto for_known = [&](const auto& visit) {
    tiles.for_all([&](TileIndex index, const Tile& tile, bool) {
      for (std::int32_t i = 0; i < static_cast<std::int32_t>(Tile::kCells); ++i) {
        const std::int8_t odds = tile.odds[static_cast<std::size_t>(i)];
        if (Tile::is_known(odds))
          visit(index.x * Tile::kSide + i % Tile::kSide, index.y * Tile::kSide + i / Tile::kSide, odds);
      }
    });
  };
  for_known([&](std::int32_t x, std::int32_t y, std::int8_t) {
    low = {std::min(low.x, x), std::min(low.y, y)};
    high = {std::max(high.x, x), std::max(high.y, y)};
  });
  if (low.x > high.x) return std::nullopt;
  const std::int64_t width = std::int64_t{high.x} - low.x + 1;
  const std::int64_t height = std::int64_t{high.y} - low.y + 1;
  if (width > kMostCells / height) throw Error(fmt::format("a grid of {} x {} cells is no picture", width, height));
  GridView view;
  view.T_map_grid = Pose::planar(low.x * resolution, low.y * resolution, 0.0);
  view.resolution_m = resolution;
  view.width = static_cast<int>(width);
  view.height = static_cast<int>(height);
  view.cells.assign(static_cast<std::size_t>(width * height), GridView::kUnknown);
  for_known([&](std::int32_t x, std::int32_t y, std::int8_t odds) {
    view.cells[static_cast<std::size_t>((y - low.y) * width + (x - low.x))] = percent[static_cast<std::uint8_t>(odds)];
  });
  return view;
}

void require_resolution(double found, double expected) {
  if (found == expected) return;
  throw DataError(fmt::format("checkpoint: the grid has cells of {} m, but resolution_m is {}", found, expected));
}

}  // namespace waymark::grid
