// SPDX-License-Identifier: Apache-2.0
#include "voxel_tile.hpp"

#include <algorithm>
#include <limits>
#include <memory>

#include "waymark/error.hpp"

namespace waymark::octo {

Slab& VoxelTile::write_slab(std::int32_t z) {
  std::int8_t& at = slab_of_[static_cast<std::size_t>(z & (VoxelOctree::kSide - 1))];
  if (at == kNone) {
    at = static_cast<std::int8_t>(slabs_.size());
    slabs_.emplace_back();
  }
  return slabs_[static_cast<std::size_t>(at)];
}

void VoxelTile::save(OutArchive& out) const {
  voxels.save(out);
  out.bytes(slab_of_.data(), slab_of_.size());
  out.value(static_cast<std::uint8_t>(slabs_.size()));
  for (const Slab& slab : slabs_) {
    out.bytes(slab.distance.data(), slab.distance.size());
    out.bytes(slab.occupied.data(), sizeof slab.occupied);
  }
}

void VoxelTile::load(InArchive& in) {
  voxels.load(in);
  in.bytes(slab_of_.data(), slab_of_.size());
  std::uint8_t count = 0;
  in.value(count);
  const bool fits = count <= VoxelOctree::kSide &&
                    std::ranges::all_of(slab_of_, [&](std::int8_t at) { return at >= kNone && at < int{count}; });
  if (!fits) throw DataError("checkpoint: tiles: layers that are not there");
  slabs_.resize(count);
  for (Slab& slab : slabs_) {
    in.bytes(slab.distance.data(), slab.distance.size());
    in.bytes(slab.occupied.data(), sizeof slab.occupied);
  }
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
    if (seen.insert(placed.tile.identity()).second) sum += placed.tile->bytes();
  }
  return sum;
}

void TileColumn::save(OutArchive& out) const {
  out.value(static_cast<std::uint32_t>(tiles_.size()));
  for (const Placed& placed : tiles_) {
    out.value(placed.z);
    if (out.first_sight(placed.tile.identity())) placed.tile->save(out);
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
    in.value(placed.z);
    if (placed.z <= below) throw DataError("checkpoint: tiles: a column out of order");
    below = placed.z;
    std::uint64_t number = 0;
    if (const auto known = in.shared(number)) {
      placed.tile = *std::static_pointer_cast<Cow<VoxelTile>>(known);
    } else {
      placed.tile.write().load(in);
      in.remember(number, std::make_shared<Cow<VoxelTile>>(placed.tile));
    }
    tiles_.push_back(std::move(placed));
  }
}

}  // namespace waymark::octo
