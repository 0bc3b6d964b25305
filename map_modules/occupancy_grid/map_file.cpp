// SPDX-License-Identifier: Apache-2.0
#include "map_file.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "distance_field.hpp"
#include "greymap.hpp"
#include "tile_window.hpp"

namespace waymark::grid {

namespace {

/// What the YAML says.
struct Legend {
  explicit Legend(const Config& config)
      : image(config.text("image")),
        resolution(config.number_in("resolution", 0.005, 10.0)),
        origin(config.numbers("origin", 3)),
        negate(config.integer_in("negate", 0, 1, 0) == 1),
        occupied_above(config.number_in("occupied_thresh", 0.0, 1.0)),
        free_below(config.number_in("free_thresh", 0.0, 1.0)) {
    config.choice("mode", {"trinary"}, "trinary");
    if (origin[2] != 0.0) config.fail("origin", "the third number, the yaw, must be 0");
    if (free_below > occupied_above) config.fail("free_thresh", "must not exceed occupied_thresh");
    config.reject_unread();
  }
  std::filesystem::path image;
  double resolution;
  std::vector<double> origin;
  bool negate;
  double occupied_above;
  double free_below;
};

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
    update_distances({}, placed.occupied, window);
  }
}

}  // namespace

LoadedMap load_map_file(const std::filesystem::path& yaml, const OddsSettings& odds) {
  const Legend legend(Config::load(yaml));
  const Greymap picture = read_greymap(yaml.parent_path() / legend.image);
  LoadedMap map;
  map.resolution = legend.resolution;
  map.corner = {legend.origin[0], legend.origin[1]};
  Tile* tile = nullptr;
  TileIndex at;
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const auto row = static_cast<std::size_t>(picture.height - 1 - y);
      const auto place = row * static_cast<std::size_t>(picture.width) + static_cast<std::size_t>(x);
      const double light = static_cast<double>(picture.pixels[place]) / picture.white;
      const double p = legend.negate ? light : 1.0 - light;
      const bool occupied = p > legend.occupied_above;
      if (!occupied && p >= legend.free_below) continue;
      const TileIndex index = Tile::index_of({x, y});
      if (tile == nullptr || index != at) tile = &map.tiles.write(at = index);
      const int value = occupied ? std::max(1, odds.high / 2) : std::min(-1, odds.low / 2);
      tile->odds[Tile::place(x, y)] = static_cast<std::int8_t>(value);
    }
  }
  compute_distances(map.tiles);
  return map;
}

}  // namespace waymark::grid
