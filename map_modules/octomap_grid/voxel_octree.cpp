// SPDX-License-Identifier: Apache-2.0
#include "map_modules/octomap_grid/voxel_octree.hpp"

#include <algorithm>
#include <cmath>

#include "waymark/base/error.hpp"
#include "waymark/memory/shared_archive.hpp"

namespace waymark::octomap_grid {

namespace {

constexpr std::size_t kBlocks = VoxelBrick::kBlocks;

/// The part of a cube's bits that is about one brick.
VoxelBrick::Bits of_brick(const VoxelOctree::Bits& bits, std::size_t brick) {
  return std::span<const std::uint64_t>(bits).subspan(brick * kBlocks).first<kBlocks>();
}

bool any(VoxelBrick::Bits bits) {
  std::uint64_t all = 0;
  for (const std::uint64_t word : bits) all |= word;
  return all != 0;
}

}  // namespace

/// The leaf's place in the octree's order, taken apart again.
LocalVoxel VoxelOctree::voxel_at(std::size_t place) {
  LocalVoxel voxel;
  for (int bit = 0; bit < kBits; ++bit) {
    voxel.x = static_cast<std::uint8_t>(voxel.x | ((place >> (3 * bit)) & 1) << bit);
    voxel.y = static_cast<std::uint8_t>(voxel.y | ((place >> (3 * bit + 1)) & 1) << bit);
    voxel.z = static_cast<std::uint8_t>(voxel.z | ((place >> (3 * bit + 2)) & 1) << bit);
  }
  return voxel;
}

void VoxelOctree::Draft::set(LocalVoxel voxel, int level, float odds_of_all) {
  const std::size_t count = std::size_t{1} << (3 * level);
  const std::size_t first = place(voxel.x, voxel.y, voxel.z) & ~(count - 1);
  for (std::size_t i = first; i < first + count; ++i) {
    known[i >> 6] |= std::uint64_t{1} << (i & 63);
    odds[i] = odds_of_all;
  }
}

VoxelOctree::VoxelOctree(const Draft& draft) {
  for (std::size_t brick = 0; brick < kBricks; ++brick) {
    const VoxelBrick::Bits known = of_brick(draft.known, brick);
    if (!any(known)) continue;
    BrickDraft packed;
    for (std::size_t i = 0; i < kBlocks; ++i) packed.add(known[i], &draft.odds[(brick * kBlocks + i) * 64]);
    set(brick, packed);
  }
}

void VoxelOctree::set(std::size_t brick, const BrickDraft& draft) {
  const auto bit = static_cast<std::uint8_t>(1u << brick);
  if (draft.is_one()) {
    whole_ = static_cast<std::uint8_t>(whole_ | bit);
    whole_odds_[brick] = draft.blocks().front().odds;
    bricks_[brick] = {};
  } else {
    whole_ = static_cast<std::uint8_t>(whole_ & ~bit);
    bricks_[brick] = draft.brick();
  }
}

const VoxelBrick::Blocks& VoxelOctree::blocks(std::size_t brick, VoxelBrick::Blocks& room) const {
  if (bricks_[brick]) return bricks_[brick].blocks();
  constexpr std::uint64_t kAll = ~std::uint64_t{0};
  room.fill(is_whole(brick) ? VoxelBlock{kAll, kAll, whole_odds_[brick], 0} : VoxelBlock{});
  return room;
}

void VoxelOctree::unpack(Draft& draft) const {
  VoxelBrick::Blocks room;
  for (std::size_t brick = 0; brick < kBricks; ++brick) {
    const VoxelBrick::Blocks& from = blocks(brick, room);
    for (std::size_t i = 0; i < kBlocks; ++i) {
      const std::size_t word = brick * kBlocks + i;
      draft.known[word] = from[i].known;
      for (std::uint64_t rest = from[i].known; rest != 0; rest &= rest - 1) {
        const auto voxel = static_cast<unsigned>(std::countr_zero(rest));
        draft.odds[word * 64 + voxel] = from[i].at(voxel, values(brick));
      }
    }
  }
}

bool VoxelOctree::is_unknown() const {
  return whole_ == 0 && std::ranges::none_of(bricks_, [](const VoxelBrick& brick) { return static_cast<bool>(brick); });
}

const float* VoxelOctree::find(LocalVoxel voxel) const {
  const std::size_t at = place(voxel.x, voxel.y, voxel.z);
  const std::size_t brick = at / VoxelBrick::kVoxels;
  if (is_whole(brick)) return &whole_odds_[brick];
  if (!bricks_[brick]) return nullptr;
  const VoxelBlock& block = bricks_[brick].blocks()[at / 64 % kBlocks];
  const auto in_block = static_cast<unsigned>(at % 64);
  if ((block.known >> in_block & 1u) == 0) return nullptr;
  return &block.at(in_block, values(brick));
}

std::uint64_t VoxelOctree::changing(const Marks& marks, const VoxelOdds& odds) const {
  VoxelBrick::Blocks room;
  std::uint64_t changing = 0;
  for (std::size_t brick = 0; brick < kBricks; ++brick) {
    const VoxelBrick::Bits free = of_brick(marks.free, brick);
    const VoxelBrick::Bits hit = of_brick(marks.hit, brick);
    if (!any(free) && !any(hit)) continue;
    const VoxelBrick::Blocks& from = blocks(brick, room);
    for (std::size_t i = 0; i < kBlocks; ++i) {
      const bool changes = would_change(from[i], values(brick), free[i], hit[i], odds);
      changing |= std::uint64_t{changes} << (brick * kBlocks + i);
    }
  }
  return changing;
}

void VoxelOctree::apply(const Marks& marks, std::uint64_t changing, const VoxelOdds& odds,
                        std::vector<LocalVoxel>& occupied, std::vector<LocalVoxel>& freed) {
  VoxelBrick::Blocks room;
  for (std::size_t brick = 0; brick < kBricks; ++brick) {
    if ((changing >> (brick * kBlocks) & 0xffu) == 0) continue;  // the brick may stay shared
    const VoxelBrick::Blocks& from = blocks(brick, room);
    const float* const own_values = values(brick);
    BrickDraft draft;
    for (std::size_t i = 0; i < kBlocks; ++i) {
      const std::size_t block = brick * kBlocks + i;
      if ((changing >> block & 1u) == 0) {
        draft.add(from[i], own_values);
        continue;
      }
      add_updated(draft, from[i], own_values, marks.free[block], marks.hit[block], odds,
                  [&](unsigned voxel, bool is_now_occupied) {
                    (is_now_occupied ? occupied : freed).push_back(voxel_at(block * 64 + voxel));
                  });
    }
    set(brick, draft);
  }
}

bool VoxelOctree::is_unknown(const Draft& draft, std::size_t first, int level) {
  if (level < 2) {
    const std::uint64_t mask = level == 0 ? 1 : 0xff;
    return (draft.known[first >> 6] >> (first & 63) & mask) == 0;
  }
  const auto begin = draft.known.begin() + static_cast<std::ptrdiff_t>(first >> 6);
  return std::all_of(begin, begin + (std::ptrdiff_t{1} << (3 * (level - 2))), [](std::uint64_t w) { return w == 0; });
}

bool VoxelOctree::is_one(const Draft& draft, std::size_t first, int level) {
  for (std::size_t i = first; i < first + (std::size_t{1} << (3 * level)); ++i) {
    if ((draft.known[i >> 6] >> (i & 63) & 1u) == 0 || draft.odds[i] != draft.odds[first]) return false;
  }
  return true;
}

std::size_t VoxelOctree::nodes_below(const Draft& draft, std::size_t first, int level) {
  if (is_unknown(draft, first, level)) return 0;
  if (is_one(draft, first, level)) return 1;
  std::size_t sum = 1;
  for (std::size_t i = 0; i < 8; ++i) sum += nodes_below(draft, first + (i << (3 * (level - 1))), level - 1);
  return sum;
}

std::size_t VoxelOctree::nodes() const {
  Draft draft;
  unpack(draft);
  return nodes_below(draft, 0, kBits);
}

std::size_t VoxelOctree::bytes(std::set<const void*>& seen) const {
  std::size_t sum = 0;
  for (const VoxelBrick& brick : bricks_) {
    if (brick && seen.insert(brick.identity()).second) sum += brick.bytes();
  }
  return sum;
}

void VoxelOctree::save(OutArchive& out) const {
  std::uint8_t there = 0;
  for (std::size_t i = 0; i < kBricks; ++i)
    there = static_cast<std::uint8_t>(there | static_cast<unsigned>(bricks_[i] ? 1 : 0) << i);
  out.value(there);
  out.value(whole_);
  for (std::size_t i = 0; i < kBricks; ++i) {
    if (is_whole(i)) out.value(whole_odds_[i]);
    if (bricks_[i]) save_shared(bricks_[i].identity(), out, [&] { bricks_[i].save(out); });
  }
}

void VoxelOctree::load(InArchive& in) {
  VoxelOctree loaded;
  std::uint8_t there = 0;
  in.value(there);
  in.value(loaded.whole_);
  if ((there & loaded.whole_) != 0) throw DataError("checkpoint: voxels: a brick that is also one leaf");
  for (std::size_t i = 0; i < kBricks; ++i) {
    if (loaded.is_whole(i)) {
      in.value(loaded.whole_odds_[i]);
      if (!std::isfinite(loaded.whole_odds_[i])) throw DataError("checkpoint: voxels: log-odds that are not finite");
    }
    if ((there >> i & 1u) != 0) loaded.bricks_[i] = load_shared<VoxelBrick>(in, [&] { return VoxelBrick::loaded(in); });
  }
  *this = std::move(loaded);
}

}  // namespace waymark::octomap_grid
