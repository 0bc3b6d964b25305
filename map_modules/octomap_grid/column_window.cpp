// SPDX-License-Identifier: Apache-2.0
#include "map_modules/octomap_grid/column_window.hpp"

#include <algorithm>

#include "map_modules/shared/scan_matching/distance_field.hpp"

namespace waymark::octomap_grid {

namespace {

const Slab& far_layer() {
  static const Slab slab;
  return slab;
}

/// The cells of one layer, out of a list that is sorted by layers.
void take_layer(std::vector<LayerCell>::const_iterator& at, std::vector<LayerCell>::const_iterator end, std::int32_t z,
                std::vector<Cell>& out) {
  out.clear();
  for (; at != end && at->first == z; ++at) out.push_back(at->second);
}

}  // namespace

void ColumnWindow::open(VoxelMap& map, const Eigen::Vector2d& low, const Eigen::Vector2d& high, double resolution) {
  map_ = &map;
  rect_ = TileRect::around(low, high, resolution * VoxelOctree::kSide);
  columns_.resize(rect_.size());
  map.gather(rect_, columns_);
  own_.assign(rect_.size(), nullptr);
}

TileColumn& ColumnWindow::writable(std::size_t slot) {
  if (own_[slot] == nullptr) {
    own_[slot] = &map_->write(tile_index(slot));
    columns_[slot] = own_[slot];
  }
  return *own_[slot];
}

void LayerWindow::open(ColumnWindow& columns, std::int32_t z) {
  columns_ = &columns;
  z_ = z;
  slabs_.assign(columns.rect().size(), nullptr);
  own_.assign(columns.rect().size(), nullptr);
}

const Slab& LayerWindow::find(std::size_t slot) {
  const VoxelTile* tile = columns_->column(slot).find(tile_of(z_));
  const Slab* slab = tile == nullptr ? nullptr : tile->slab(z_);
  slabs_[slot] = slab == nullptr ? &far_layer() : slab;
  return *slabs_[slot];
}

void LayerWindow::set_distance(int x, int y, std::uint8_t distance) {
  const std::size_t at = slot(x, y);
  if (own_[at] == nullptr) {
    own_[at] = &columns_->writable(at).write(tile_of(z_)).write_slab(z_);
    slabs_[at] = own_[at];
  }
  own_[at]->distance[Slab::place(x, y)] = distance;
}

void DistanceUpdate::apply(ColumnWindow& window, std::vector<LayerCell>& freed, std::vector<LayerCell>& occupied) {
  std::ranges::stable_sort(freed, {}, &LayerCell::first);
  std::ranges::stable_sort(occupied, {}, &LayerCell::first);
  auto f = freed.cbegin();
  auto o = occupied.cbegin();
  while (f != freed.cend() || o != occupied.cend()) {
    std::int32_t z = f != freed.cend() ? f->first : o->first;
    if (o != occupied.cend()) z = std::min(z, o->first);
    take_layer(f, freed.cend(), z, freed_);
    take_layer(o, occupied.cend(), z, occupied_);
    layer_.open(window, z);
    scan_matching::update_distances(freed_, occupied_, layer_);
  }
}

}  // namespace waymark::octomap_grid
