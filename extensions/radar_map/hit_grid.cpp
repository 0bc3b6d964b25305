// SPDX-License-Identifier: Apache-2.0
#include "hit_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "waymark/base/error.hpp"
#include "waymark/memory/shared_archive.hpp"

namespace waymark::radar_map {
namespace {

constexpr double kFarthest = 1e8;  // [cells] from the origin
constexpr std::uint16_t kMostHits = std::numeric_limits<std::uint16_t>::max();

}  // namespace

void HitGrid::insert(const PoseGaussian& pose, const Observation& observation, const Association*) {
  const auto& points = static_cast<const StillTargets&>(observation).points_base;
  if (points.empty()) return;
  Tiles& tiles = tiles_.write();
  for (const Eigen::Vector2d& point : points) {
    const Eigen::Vector3d p_map = pose.T_map_base * Eigen::Vector3d(point.x(), point.y(), 0.0);
    const Eigen::Vector2d cell = (p_map.head<2>() / resolution_m_).array().floor();
    if (!(cell.cwiseAbs().maxCoeff() < kFarthest)) continue;
    const Eigen::Vector2d tile = (cell / kSide).array().floor();
    const Eigen::Vector2d within = cell - kSide * tile;
    const auto at = static_cast<std::size_t>(within.y()) * kSide + static_cast<std::size_t>(within.x());
    const Place place(static_cast<std::int32_t>(tile.y()), static_cast<std::int32_t>(tile.x()));
    auto found = tiles.find(place);
    if (found == tiles.end()) found = tiles.emplace(place, Cow<Tile>(Tile{})).first;
    std::uint16_t& hits = found->second.write()[at];
    if (hits < kMostHits) ++hits;
  }
}

void HitGrid::describe(MapDescription& out) const {
  double cells = 0.0;
  for (const auto& [place, tile] : tiles_.read())
    cells += static_cast<double>(kSide * kSide - std::ranges::count(tile.read(), 0));
  out.figures.push_back({"cells with targets", cells});
}

std::optional<GridView> HitGrid::grid() const {
  const Tiles& tiles = tiles_.read();
  if (tiles.empty()) return std::nullopt;
  std::int32_t left = std::numeric_limits<std::int32_t>::max();
  std::int32_t right = std::numeric_limits<std::int32_t>::min();
  for (const auto& [place, tile] : tiles) {
    left = std::min(left, place.second);
    right = std::max(right, place.second);
  }
  const std::int32_t bottom = tiles.begin()->first.first;
  const std::int32_t top = tiles.rbegin()->first.first;
  GridView view;
  view.T_map_grid = Pose::planar(resolution_m_ * kSide * left, resolution_m_ * kSide * bottom, 0.0);
  view.resolution_m = resolution_m_;
  view.width = kSide * (right - left + 1);
  view.height = kSide * (top - bottom + 1);
  view.cells.assign(static_cast<std::size_t>(view.width) * static_cast<std::size_t>(view.height), GridView::kUnknown);
  for (const auto& [place, tile] : tiles) {
    for (std::size_t i = 0; i < tile.read().size(); ++i) {
      const std::uint16_t hits = tile.read()[i];
      if (hits == 0) continue;
      const auto row = static_cast<std::size_t>(kSide * (place.first - bottom)) + i / kSide;
      const auto column = static_cast<std::size_t>(kSide * (place.second - left)) + i % kSide;
      const double occupied = 1.0 - std::pow(1.0 - hit_, hits);
      view.cells[row * static_cast<std::size_t>(view.width) + column] =
          static_cast<std::uint8_t>(std::lround(100.0 * occupied));
    }
  }
  return view;
}

void HitGrid::save(OutArchive& out) const {
  out.section("hit grid", 1);
  out.value(static_cast<std::uint64_t>(tiles_.read().size()));
  for (const auto& [place, tile] : tiles_.read()) {
    out.value(place.first);
    out.value(place.second);
    const Cow<Tile>& shared = tile;
    save_shared(shared.identity(), out, [&] { out.bytes(shared.read().data(), sizeof(Tile)); });
  }
}

void HitGrid::load(InArchive& in) {
  in.section("hit grid", 1);
  std::uint64_t count = 0;
  in.value(count);
  Tiles tiles;
  for (std::uint64_t i = 0; i < count; ++i) {
    Place place;
    in.value(place.first);
    in.value(place.second);
    const auto tile = load_shared<Cow<Tile>>(in, [&] {
      Tile read{};
      in.bytes(read.data(), sizeof(Tile));
      return Cow<Tile>(read);
    });
    if (!tiles.empty() && !(tiles.rbegin()->first < place)) throw DataError("tiles of a radar's map are out of order");
    tiles.emplace_hint(tiles.end(), place, tile);
  }
  tiles_ = Cow<Tiles>(std::move(tiles));
}

}  // namespace waymark::radar_map
