// SPDX-License-Identifier: Apache-2.0
#include "map_modules/occupancy_grid/grid_view.hpp"

#include <array>
#include <cmath>

#include "map_modules/shared/scan_matching/cell_entropy.hpp"
#include "plugins/shared/map_formats/grid_extent.hpp"

namespace waymark::occupancy_grid {

namespace {

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
  static const auto entropies = table_of<double>(scan_matching::entropy_bit);
  GridFigures figures;
  double entropy = 0.0;
  tiles.for_all([&](TileIndex, const Tile& tile, bool is_shared) {
    ++figures.tiles;
    figures.tiles_shared += is_shared;
    for (std::size_t i = 0; i < Tile::kCells; ++i) {
      const std::int8_t odds = tile.odds[i];
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
  const auto for_known = [&](const auto& visit) {
    tiles.for_all([&](TileIndex index, const Tile& tile, bool) {
      for (std::int32_t i = 0; i < static_cast<std::int32_t>(Tile::kCells); ++i) {
        const std::int8_t odds = tile.odds[static_cast<std::size_t>(i)];
        if (Tile::is_known(odds))
          visit(index.x * Tile::kSide + i % Tile::kSide, index.y * Tile::kSide + i / Tile::kSide, odds);
      }
    });
  };
  map_formats::GridExtent extent;
  for_known([&](std::int32_t x, std::int32_t y, std::int8_t) { extent.add(x, y); });
  if (extent.empty()) return std::nullopt;
  GridView view = extent.unknown(resolution);
  for_known([&](std::int32_t x, std::int32_t y, std::int8_t odds) {
    view.cells[extent.place(x, y)] = percent[static_cast<std::uint8_t>(odds)];
  });
  return view;
}

}  // namespace waymark::occupancy_grid
