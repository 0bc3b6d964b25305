// SPDX-License-Identifier: Apache-2.0
#include "map_modules/occupancy_grid/map_file.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "map_modules/occupancy_grid/tile_window.hpp"
#include "map_modules/shared/scan_matching/distance_field.hpp"
#include "plugins/shared/map_formats/map_server.hpp"

namespace waymark::occupancy_grid {

namespace {

/// Distances of a map of which only the odds are known, tile by tile.
void compute_distances(TileTree& tiles) {
  struct Placed {
    TileIndex index;
    std::vector<Cell> occupied;
  };
  std::vector<Placed> all;
  tiles.for_all([&](TileIndex index, const Tile& tile, bool) {
    std::vector<Cell> occupied;
    for (std::size_t i = 0; i < Tile::kCells; ++i) {
      if (!Tile::is_occupied(tile.odds[i])) continue;
      const auto place = static_cast<std::int32_t>(i);
      occupied.push_back({place % Tile::kSide, place / Tile::kSide});
    }
    if (!occupied.empty()) all.push_back({index, std::move(occupied)});
  });
  WritableWindow window;
  for (Placed& placed : all) {
    // In cells, so that the window is the tile and its neighbours.
    const Eigen::Vector2d middle((placed.index.x + 0.5) * Tile::kSide, (placed.index.y + 0.5) * Tile::kSide);
    window.open_for_writing(tiles, middle, Tile::kSide, 1.0);
    for (Cell& cell : placed.occupied) {
      cell.x += placed.index.x * Tile::kSide - window.origin().x;
      cell.y += placed.index.y * Tile::kSide - window.origin().y;
    }
    scan_matching::update_distances({}, placed.occupied, window);
  }
}

}  // namespace

LoadedMap load_map_file(const std::filesystem::path& yaml, const scan_matching::OddsSettings& odds) {
  const GridView picture = map_formats::read_map_server(yaml);
  LoadedMap map;
  map.resolution = picture.resolution_m;
  map.T_map_grid = picture.T_map_grid;
  Tile* tile = nullptr;
  TileIndex at;
  auto percent = picture.cells.begin();
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x, ++percent) {
      if (*percent == GridView::kUnknown) continue;
      const TileIndex index = Tile::index_of({x, y});
      if (tile == nullptr || index != at) tile = &map.tiles.write(at = index);
      const int value = *percent > 50 ? std::max(1, odds.high / 2) : std::min(-1, odds.low / 2);
      tile->odds.set(Tile::place(x, y), static_cast<std::int8_t>(value));
    }
  }
  compute_distances(map.tiles);
  return map;
}

}  // namespace waymark::occupancy_grid
