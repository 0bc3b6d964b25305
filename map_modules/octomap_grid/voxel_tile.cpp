// SPDX-License-Identifier: Apache-2.0
#include "map_modules/octomap_grid/voxel_tile.hpp"

#include <algorithm>
#include <limits>

#include "waymark/base/error.hpp"
#include "waymark/memory/shared_archive.hpp"

namespace waymark::octomap_grid {

namespace {

void save_slab(const Slab& slab, OutArchive& out) {
  out.bytes(slab.distance.data(), slab.distance.size());
  out.bytes(slab.occupied.data(), sizeof slab.occupied);
}

Cow<Slab> load_slab(InArchive& in) {
  Cow<Slab> handle;
  Slab& slab = handle.write();
  in.bytes(slab.distance.data(), slab.distance.size());
  in.bytes(slab.occupied.data(), sizeof slab.occupied);
  return handle;
}

/// A handle to what its own `load` reads.
template <class T>
Cow<T> loaded(InArchive& in) {
  Cow<T> handle;
  handle.write().load(in);
  return handle;
}

}  // namespace

Slab& Layers::write(std::int32_t z) {
  std::int8_t& at = slab_of_[static_cast<std::size_t>(z & (VoxelOctree::kSide - 1))];
  if (at == kNone) {
    at = static_cast<std::int8_t>(slabs_.size());
    slabs_.emplace_back();
  }
  return slabs_[static_cast<std::size_t>(at)].write();
}

std::size_t Layers::bytes(std::set<const void*>& seen) const {
  std::size_t sum = sizeof(Layers) + slabs_.size() * sizeof(Cow<Slab>);
  for (const Cow<Slab>& slab : slabs_) {
    if (seen.insert(slab.identity()).second) sum += sizeof(Slab);
  }
  return sum;
}

void Layers::save(OutArchive& out) const {
  out.bytes(slab_of_.data(), slab_of_.size());
  out.value(static_cast<std::uint8_t>(slabs_.size()));
  for (const Cow<Slab>& slab : slabs_) save_shared(slab.identity(), out, [&] { save_slab(slab.read(), out); });
}

void Layers::load(InArchive& in) {
  in.bytes(slab_of_.data(), slab_of_.size());
  std::uint8_t count = 0;
  in.value(count);
  const bool fits = count <= VoxelOctree::kSide &&
                    std::ranges::all_of(slab_of_, [&](std::int8_t at) { return at >= kNone && at < int{count}; });
  if (!fits) throw DataError("checkpoint: tiles: layers that are not there");
  slabs_.clear();
  slabs_.reserve(count);
  for (unsigned i = 0; i < count; ++i) slabs_.push_back(load_shared<Cow<Slab>>(in, [&] { return load_slab(in); }));
}

Slab& VoxelTile::write_slab(std::int32_t z) {
  if (!layers_) layers_.emplace();
  return layers_->write().write(z);
}

std::size_t VoxelTile::bytes(std::set<const void*>& seen) const {
  std::size_t sum = sizeof(VoxelTile) + voxels.bytes(seen);
  if (layers_ && seen.insert(layers_->identity()).second) sum += layers_->read().bytes(seen);
  return sum;
}

void VoxelTile::save(OutArchive& out) const {
  voxels.save(out);
  out.value(layers_.has_value());
  if (layers_) save_shared(layers_->identity(), out, [&] { layers_->read().save(out); });
}

void VoxelTile::load(InArchive& in) {
  voxels.load(in);
  bool has_layers = false;
  in.value(has_layers);
  layers_.reset();
  if (has_layers) layers_ = load_shared<Cow<Layers>>(in, [&] { return loaded<Layers>(in); });
}

const VoxelTile* TileColumn::find(std::int32_t z) const {
  for (const Placed& placed : tiles_) {
    if (placed.z == z) return &placed.tile.read();
  }
  return nullptr;
}

VoxelTile& TileColumn::write(std::int32_t z) {
  auto at = std::ranges::lower_bound(tiles_, z, {}, &Placed::z);
  if (at == tiles_.end() || at->z != z) at = tiles_.insert(at, {z, {}});
  return at->tile.write();
}

std::size_t TileColumn::bytes(std::set<const void*>& seen) const {
  std::size_t sum = sizeof(TileColumn) + tiles_.size() * sizeof(Placed);
  for (const Placed& placed : tiles_) {
    if (seen.insert(placed.tile.identity()).second) sum += placed.tile->bytes(seen);
  }
  return sum;
}

void TileColumn::save(OutArchive& out) const {
  out.value(static_cast<std::uint32_t>(tiles_.size()));
  for (const Placed& placed : tiles_) {
    out.value(placed.z);
    save_shared(placed.tile.identity(), out, [&] { placed.tile->save(out); });
  }
}

void TileColumn::load(InArchive& in) {
  std::uint32_t count = 0;
  in.value(count);
  tiles_.clear();
  tiles_.reserve(std::min(count, 1024U));  // a damaged count must not take all memory
  std::int64_t below = std::numeric_limits<std::int64_t>::min();
  for (std::uint32_t i = 0; i < count; ++i) {
    Placed placed{};
    in.within(placed.z, -TileIndex::kMost, TileIndex::kMost);
    if (placed.z <= below) throw DataError("checkpoint: tiles: a column out of order");
    below = placed.z;
    placed.tile = load_shared<Cow<VoxelTile>>(in, [&] { return loaded<VoxelTile>(in); });
    tiles_.push_back(std::move(placed));
  }
}

}  // namespace waymark::octomap_grid
