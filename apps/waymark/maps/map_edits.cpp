// SPDX-License-Identifier: Apache-2.0
#include "map_edits.hpp"

#include <fmt/format.h>

#include <GeographicLib/LocalCartesian.hpp>
#include <algorithm>
#include <cmath>
#include <utility>

#include "octree_edits.hpp"
#include "plugins/shared/map_formats/grid_extent.hpp"
#include "plugins/shared/map_formats/map_manifest.hpp"
#include "waymark/base/error.hpp"

namespace waymark::maps {

namespace {

constexpr std::uint8_t kHalfPercent = 50;  // above

/// Calls visit(x, y, percent) for every known cell.
template <class Visit>
void for_known(const GridView& grid, const Visit& visit) {
  std::size_t place = 0;
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x, ++place) {
      if (grid.cells[place] != GridView::kUnknown) visit(x, y, grid.cells[place]);
    }
  }
}

Eigen::Vector3d middle_of(const GridView& grid, int x, int y) {
  return grid.T_map_grid * Eigen::Vector3d((x + 0.5) * grid.resolution_m, (y + 0.5) * grid.resolution_m, 0.0);
}

/// The picture of the cells that `for_cells(add)` adds; they count from the corner of `grid`.
template <class Cells>
GridView redrawn(const GridView& grid, const Cells& for_cells) {
  map_formats::GridExtent extent;
  int low_x = std::numeric_limits<int>::max();
  int low_y = std::numeric_limits<int>::max();
  for_cells([&](int x, int y, std::uint8_t) {
    extent.add(x, y);
    low_x = std::min(low_x, x);
    low_y = std::min(low_y, y);
  });
  if (extent.empty()) return {};
  GridView out = extent.unknown(grid.resolution_m);
  out.T_map_grid = grid.T_map_grid * Pose::planar(low_x * grid.resolution_m, low_y * grid.resolution_m, 0.0);
  for_cells([&](int x, int y, std::uint8_t percent) {
    std::uint8_t& cell = out.cells[extent.place(x, y)];
    // Occupied in one of both counts.
    if (cell == GridView::kUnknown || cell <= kHalfPercent) cell = percent;
  });
  return out;
}

void merge_landmarks(Landmarks& mine, const Landmarks& others, double same_landmark_m) {
  const std::size_t count = mine.size();
  for (const map_formats::LandmarkEntry& other : others) {
    const auto distance = [&](const map_formats::LandmarkEntry& one) {
      return (one.mean - other.mean).head<2>().norm();
    };
    const auto end = mine.begin() + static_cast<std::ptrdiff_t>(count);
    const auto nearest = std::ranges::min_element(mine.begin(), end, {}, distance);
    if (nearest == end || distance(*nearest) > same_landmark_m) {
      mine.push_back(other);
    } else if (other.P.trace() < nearest->P.trace()) {
      *nearest = other;
    }
  }
}

void merge_grids(GridView& mine, const GridView& other) {
  if (std::abs(mine.resolution_m - other.resolution_m) > 1e-9) {
    throw Error(fmt::format("cells of {} m and of {} m; grids of one resolution are expected", mine.resolution_m,
                            other.resolution_m));
  }
  const Pose T_mine_map = mine.T_map_grid.inverse();
  constexpr double kFarthest = 1e9;  // cells
  mine = redrawn(mine, [&](const auto& add) {
    for_known(mine, add);
    for_known(other, [&](int x, int y, std::uint8_t percent) {
      const Eigen::Vector3d p = T_mine_map * middle_of(other, x, y) / mine.resolution_m;
      if (!(p.cwiseAbs().maxCoeff() < kFarthest)) throw Error("the grids lie too far apart for one");
      add(static_cast<int>(std::floor(p.x())), static_cast<int>(std::floor(p.y())), percent);
    });
  });
}

}  // namespace

void crop(LayeredMap& map, const Box& box) {
  std::erase_if(map.layers, [&](Layer& layer) {
    if (auto* landmarks = std::get_if<Landmarks>(&layer.content)) {
      std::erase_if(*landmarks, [&](const map_formats::LandmarkEntry& one) {
        const double height = std::clamp(0.0, box.low, box.high);
        return !box.holds({one.mean.x(), one.mean.y(), height});
      });
      return landmarks->empty();
    }
    if (auto* grid = std::get_if<GridView>(&layer.content)) {
      *grid = redrawn(*grid, [&](const auto& add) {
        for_known(*grid, [&](int x, int y, std::uint8_t percent) {
          Eigen::Vector3d p = middle_of(*grid, x, y);
          p.z() = std::clamp(0.0, box.low, box.high);
          if (box.holds(p)) add(x, y, percent);
        });
      });
      return grid->cells.empty();
    }
    auto& octree = std::get<LoadedOctree>(layer.content);
    octree.tree = crop_octree(*octree.tree, box, layer.T_frame_file);
    return octree.tree->size() == 0;
  });
  if (map.layers.empty()) {
    throw Error(fmt::format("nothing of the map lies between x {} and {} m, y {} and {} m", box.west, box.east,
                            box.south, box.north));
  }
}

void merge(LayeredMap& map, const LayeredMap& other, double same_landmark_m) {
  if (map.is_manifest != other.is_manifest)
    throw Error("one is a manifest and the other a single layer; two of one kind are expected");
  if (map.is_manifest) {
    const auto text = [](const LayeredMap& one) { return map_formats::datum_text(one.datum); };
    if (!map.datum || !other.datum || text(map) != text(other)) {
      throw Error(
          fmt::format("datum {} and datum {}: maps in one frame are expected; waymark map georeference moves one",
                      text(map), text(other)));
    }
  }
  for (const Layer& added : other.layers) {
    const auto mine = map.is_manifest ? std::ranges::find(map.layers, added.name, &Layer::name) : map.layers.begin();
    if (mine == map.layers.end()) {
      Layer copy{added.name, added.T_frame_file, {}};
      if (const auto* octree = std::get_if<LoadedOctree>(&added.content)) {
        copy.content = LoadedOctree{std::make_unique<octomap::OcTree>(*octree->tree), octree->format};
      } else if (const auto* grid = std::get_if<GridView>(&added.content)) {
        copy.content = *grid;
      } else {
        copy.content = std::get<Landmarks>(added.content);
      }
      map.layers.push_back(std::move(copy));
      continue;
    }
    if (mine->content.index() != added.content.index())
      throw Error(fmt::format("the layers \"{}\" and \"{}\" are of different formats", mine->name, added.name));
    if (auto* landmarks = std::get_if<Landmarks>(&mine->content)) {
      merge_landmarks(*landmarks, std::get<Landmarks>(added.content), same_landmark_m);
    } else if (auto* grid = std::get_if<GridView>(&mine->content)) {
      merge_grids(*grid, std::get<GridView>(added.content));
    } else {
      merge_octrees(*std::get<LoadedOctree>(mine->content).tree, *std::get<LoadedOctree>(added.content).tree,
                    mine->T_frame_file.inverse() * added.T_frame_file);
    }
  }
}

void move(LayeredMap& map, const Pose& T_to_from) {
  for (Layer& layer : map.layers) {
    if (auto* landmarks = std::get_if<Landmarks>(&layer.content)) {
      for (map_formats::LandmarkEntry& one : *landmarks) map_formats::move_landmark(T_to_from, one);
    } else if (auto* grid = std::get_if<GridView>(&layer.content)) {
      grid->T_map_grid = T_to_from * grid->T_map_grid;
      grid->T_map_grid.p.z() = 0.0;
    } else {
      layer.T_frame_file = T_to_from * layer.T_frame_file;
    }
  }
}

Pose between(const Datum& to, const Datum& from) {
  constexpr double kFarthest = 1e4;
  constexpr double kBase = 100.0;  // m
  const GeographicLib::LocalCartesian new_frame(to.latitude_deg, to.longitude_deg, to.height_m);
  const GeographicLib::LocalCartesian old_frame(from.latitude_deg, from.longitude_deg, from.height_m);
  Eigen::Vector3d origin;
  new_frame.Forward(from.latitude_deg, from.longitude_deg, from.height_m, origin.x(), origin.y(), origin.z());
  if (!(origin.norm() <= kFarthest)) {
    throw Error(fmt::format("the datums are {:.0f} m apart; at most {:.0f} m are possible, since the Earth is round",
                            origin.norm(), kFarthest));
  }
  double latitude = 0.0;
  double longitude = 0.0;
  double height = 0.0;
  old_frame.Reverse(kBase, 0.0, 0.0, latitude, longitude, height);
  Eigen::Vector3d east;
  new_frame.Forward(latitude, longitude, height, east.x(), east.y(), east.z());
  Pose pose = Pose::planar(origin.x(), origin.y(), std::atan2(east.y() - origin.y(), east.x() - origin.x()));
  pose.p.z() = origin.z();
  return pose;
}

}  // namespace waymark::maps
