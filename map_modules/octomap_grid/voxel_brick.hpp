// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "map_modules/octomap_grid/voxel_odds.hpp"
#include "waymark/io/archive.hpp"

namespace waymark::octomap_grid {

/// 4 × 4 × 4 voxels in the octree's order. Most are unknown or free as far as they can be: only what differs from the
/// lowest value in the block is held one by one.
struct VoxelBlock {
  std::uint64_t known = 0;
  std::uint64_t lowest = 0;  ///< those of the known that have the lowest value
  float odds = 0.0f;         ///< that value, natural log-odds
  std::uint32_t first = 0;   ///< where the values of the others begin

  std::uint64_t others() const { return known & ~lowest; }
  bool is_one() const { return lowest == ~std::uint64_t{0}; }
  /// Log-odds of a known voxel; `values` are those of the brick.
  const float& at(unsigned voxel, const float* values) const {
    const std::uint64_t bit = std::uint64_t{1} << voxel;
    return (lowest & bit) != 0 ? odds : values[first + static_cast<unsigned>(std::popcount(others() & (bit - 1)))];
  }
};

/// Occupancy of 8 × 8 × 8 voxels, in one piece of memory. What is in a brick never changes, so any number of maps hold
/// it together: a copy counts one more holder, and who writes makes another brick. May be used as `Cow` may: handles by
/// one thread each, bricks by any.
class VoxelBrick {
 public:
  static constexpr std::size_t kBlocks = 8;
  static constexpr std::size_t kVoxels = 64 * kBlocks;
  using Blocks = std::array<VoxelBlock, kBlocks>;
  /// One bit a voxel.
  using Bits = std::span<const std::uint64_t, kBlocks>;

  /// None.
  VoxelBrick() = default;
  VoxelBrick(const Blocks& blocks, std::span<const float> values);
  VoxelBrick(const VoxelBrick& other) noexcept : body_(other.body_) {
    if (body_ != nullptr) body_->owners.fetch_add(1, std::memory_order_relaxed);
  }
  VoxelBrick(VoxelBrick&& other) noexcept : body_(std::exchange(other.body_, nullptr)) {}
  VoxelBrick& operator=(VoxelBrick other) noexcept {
    std::swap(body_, other.body_);
    return *this;
  }
  ~VoxelBrick() {
    if (body_ != nullptr && body_->owners.fetch_sub(1, std::memory_order_acq_rel) == 1) release();
  }

  explicit operator bool() const { return body_ != nullptr; }
  const void* identity() const { return body_; }
  const Blocks& blocks() const { return body_->blocks; }
  const float* values() const { return reinterpret_cast<const float*>(body_ + 1); }
  std::size_t bytes() const { return sizeof(Body) + size() * sizeof(float); }

  void save(OutArchive& out) const;
  /// Throws DataError if what is read is not a valid brick.
  static VoxelBrick loaded(InArchive& in);

 private:
  struct Body {
    std::atomic<std::uint32_t> owners{1};
    Blocks blocks;
  };
  std::size_t size() const {
    return blocks().back().first + static_cast<std::size_t>(std::popcount(blocks().back().others()));
  }
  void release();

  Body* body_ = nullptr;
};

/// A brick in the making.
class BrickDraft {
 public:
  /// Appends the next block with the voxels `known`, whose values are `odds[voxel]`.
  void add(std::uint64_t known, const float* odds);
  /// Appends a block as it is.
  void add(const VoxelBlock& block, const float* values);
  /// Appends a block in which the voxels `lowest` have the value `odds` that no other is below, and `others` theirs.
  void add(std::uint64_t lowest, float odds, std::uint64_t others, const float* odds_of_others);

  const VoxelBrick::Blocks& blocks() const { return blocks_; }
  /// All 512 voxels have one value.
  bool is_one() const;
  VoxelBrick brick() const { return {blocks_, std::span(values_).first(n_values_)}; }

 private:
  VoxelBrick::Blocks blocks_;
  std::size_t n_blocks_ = 0;
  std::size_t n_values_ = 0;
  std::array<float, VoxelBrick::kVoxels> values_;  // the first n_values_ count
};

/// True if one of the voxels, which are known and not as low as others, changes with such a scan.
bool would_change_others(const VoxelBlock& block, const float* values, std::uint64_t free, std::uint64_t hit,
                         const VoxelOdds& odds);
/// True if a scan that marks a block's voxels `free` and `hit` changes one of them.
inline bool would_change(const VoxelBlock& block, const float* values, std::uint64_t free, std::uint64_t hit,
                         const VoxelOdds& odds) {
  const std::uint64_t marked = free | hit;
  if ((marked & ~block.known) != 0) return true;
  if ((free & block.lowest) != 0 && odds.after_miss(block.odds) != block.odds) return true;
  if ((hit & block.lowest) != 0 && odds.after_hit(block.odds) != block.odds) return true;
  return (marked & ~block.lowest) != 0 && would_change_others(block, values, free, hit, odds);
}
/// Appends the block after such a scan. Calls flipped(voxel, is_occupied) for voxels that became occupied or no longer
/// are, in their order.
template <class Flipped>
void add_updated(BrickDraft& draft, const VoxelBlock& block, const float* values, std::uint64_t free, std::uint64_t hit,
                 const VoxelOdds& odds, const Flipped& flipped) {
  // What is as free as it can be stays so, and nothing gets below it: usually most of the block.
  const bool stays = odds.after_miss(block.odds) == block.odds;
  const std::uint64_t kept = stays ? block.lowest & ~hit : 0;
  const std::uint64_t known = block.known | free | hit;
  std::array<float, 64> now;
  const float* next = values + block.first;  // of those that are not the lowest; they are all among the rest
  for (std::uint64_t rest = known & ~kept; rest != 0; rest &= rest - 1) {
    const auto voxel = static_cast<unsigned>(std::countr_zero(rest));
    const std::uint64_t bit = rest & (~rest + 1);
    float before = 0.0f;
    if ((block.known & bit) != 0) before = (block.lowest & bit) != 0 ? block.odds : *next++;
    const float after =
        (hit & bit) != 0 ? odds.after_hit(before) : ((free & bit) != 0 ? odds.after_miss(before) : before);
    now[voxel] = after;
    if (is_occupied(before) != is_occupied(after)) flipped(voxel, is_occupied(after));
  }
  if (kept == 0) {
    draft.add(known, now.data());
  } else {
    draft.add(kept, block.odds, known & ~kept, now.data());
  }
}

}  // namespace waymark::octomap_grid
