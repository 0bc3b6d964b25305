// SPDX-License-Identifier: Apache-2.0
#include "map_modules/octomap_grid/voxel_brick.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <new>

#include "waymark/base/error.hpp"

namespace waymark::octomap_grid {

namespace {

template <class Visit>
void for_bits(std::uint64_t bits, const Visit& visit) {
  for (; bits != 0; bits &= bits - 1) visit(static_cast<unsigned>(std::countr_zero(bits)));
}

}  // namespace

VoxelBrick::VoxelBrick(const Blocks& blocks, std::span<const float> values) {
  static_assert(sizeof(Body) % alignof(float) == 0 && alignof(Body) <= __STDCPP_DEFAULT_NEW_ALIGNMENT__);
  void* memory = ::operator new(sizeof(Body) + values.size_bytes());
  body_ = new (memory) Body{{1}, blocks};
  if (!values.empty()) std::memcpy(static_cast<void*>(body_ + 1), values.data(), values.size_bytes());
}

void VoxelBrick::release() {
  std::destroy_at(body_);
  ::operator delete(body_);
}

void VoxelBrick::save(OutArchive& out) const {
  for (const VoxelBlock& block : blocks()) {
    out.value(block.known);
    out.value(block.lowest);
    out.value(block.odds);
  }
  out.bytes(values(), size() * sizeof(float));
}

VoxelBrick VoxelBrick::loaded(InArchive& in) {
  const auto require = [](bool is_right, const char* what) {
    if (!is_right) throw DataError(std::string("checkpoint: voxels: ") + what);
  };
  Blocks blocks;
  std::uint32_t size = 0;
  for (VoxelBlock& block : blocks) {
    in.value(block.known);
    in.value(block.lowest);
    in.value(block.odds);
    require((block.lowest & ~block.known) == 0 && (block.lowest == 0) == (block.known == 0), "bits without a voxel");
    require(std::isfinite(block.odds), "log-odds that are not finite");
    block.first = size;
    size += static_cast<std::uint32_t>(std::popcount(block.others()));
  }
  std::array<float, kVoxels> values{};
  in.bytes(values.data(), size * sizeof(float));
  require(std::all_of(values.begin(), values.begin() + size, [](float v) { return std::isfinite(v); }),
          "log-odds that are not finite");
  return {blocks, std::span(values).first(size)};
}

void BrickDraft::add(std::uint64_t known, const float* odds) {
  if (known == 0) return add(VoxelBlock{}, nullptr);
  float lowest = odds[std::countr_zero(known)];
  for_bits(known, [&](unsigned voxel) { lowest = std::min(lowest, odds[voxel]); });
  add(0, lowest, known, odds);
}

void BrickDraft::add(const VoxelBlock& block, const float* values) {
  VoxelBlock& own = blocks_[n_blocks_++];
  own = block;
  own.first = static_cast<std::uint32_t>(n_values_);
  const auto size = static_cast<std::size_t>(std::popcount(block.others()));
  std::copy_n(values + block.first, size, values_.begin() + static_cast<std::ptrdiff_t>(n_values_));
  n_values_ += size;
}

void BrickDraft::add(std::uint64_t lowest, float odds, std::uint64_t others, const float* odds_of_others) {
  VoxelBlock& own = blocks_[n_blocks_++];
  own = {lowest | others, lowest, odds, static_cast<std::uint32_t>(n_values_)};
  for_bits(others, [&](unsigned voxel) {
    if (odds_of_others[voxel] == odds) {
      own.lowest |= std::uint64_t{1} << voxel;
    } else {
      values_[n_values_++] = odds_of_others[voxel];
    }
  });
}

bool BrickDraft::is_one() const {
  return std::ranges::all_of(
      blocks_, [&](const VoxelBlock& block) { return block.is_one() && block.odds == blocks_.front().odds; });
}

bool would_change_others(const VoxelBlock& block, const float* values, std::uint64_t free, std::uint64_t hit,
                         const VoxelOdds& odds) {
  for (std::uint64_t rest = (free | hit) & block.others(); rest != 0; rest &= rest - 1) {
    const float now = block.at(static_cast<unsigned>(std::countr_zero(rest)), values);
    const bool is_hit = (hit & rest & (~rest + 1)) != 0;
    if ((is_hit ? odds.after_hit(now) : odds.after_miss(now)) != now) return true;
  }
  return false;
}

}  // namespace waymark::octomap_grid
