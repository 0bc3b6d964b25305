// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <set>
#include <vector>

#include "map_modules/octomap_grid/voxel_brick.hpp"
#include "map_modules/octomap_grid/voxel_odds.hpp"
#include "waymark/io/archive.hpp"

namespace waymark::octomap_grid {

/// A voxel of one octree, 0 … kSide − 1 in each direction.
struct LocalVoxel {
  std::uint8_t x = 0;
  std::uint8_t y = 0;
  std::uint8_t z = 0;
};

/// Occupancy of a cube of 16 × 16 × 16 voxels: an octree of depth 4 whose voxels are known, each with its natural
/// log-odds, or not, and in which eight equal leaves count as one, as in OctoMap (A. Hornung et al., Autonomous Robots,
/// 2013). No octomap::OcTree and none of its nodes: those take 24 bytes a voxel and must be copied one by one. Here the
/// leaves lie in the octree's order (I. Gargantini, CACM 1982) in eight bricks, which copies share.
class VoxelOctree {
 public:
  static constexpr int kBits = 4;
  static constexpr int kSide = 1 << kBits;
  static constexpr std::size_t kVoxels = std::size_t{1} << (3 * kBits);

  /// One bit a voxel, in the order of the octree's leaves.
  using Bits = std::array<std::uint64_t, kVoxels / 64>;
  /// The voxels that one scan marks; none is in both.
  struct Marks {
    Bits free{};
    Bits hit{};
  };
  /// All voxels one by one.
  struct Draft {
    /// Gives the cube of 2^level voxels in each direction around `voxel` one value.
    void set(LocalVoxel voxel, int level, float odds_of_all);

    Bits known{};
    std::array<float, kVoxels> odds{};
  };
  /// Place of a voxel in `Bits`; only the last four bits of each count.
  static std::size_t place(std::int32_t x, std::int32_t y, std::int32_t z) {
    return spread(x) | spread(y) << 1 | spread(z) << 2;
  }

  VoxelOctree() = default;
  explicit VoxelOctree(const Draft& draft);

  bool is_unknown() const;
  /// Log-odds of a voxel, or null if it is unknown.
  const float* find(LocalVoxel voxel) const;
  /// The blocks of 64 voxels that a scan changes, one bit each.
  std::uint64_t changing(const Marks& marks, const VoxelOdds& odds) const;
  /// Updates every marked voxel of these blocks once; appends those that became occupied, and those that no longer are.
  void apply(const Marks& marks, std::uint64_t changing, const VoxelOdds& odds, std::vector<LocalVoxel>& occupied,
             std::vector<LocalVoxel>& freed);

  /// Calls visit(LocalVoxel of the lowest corner, side in voxels, log-odds) for all leaves, in a fixed order. Eight
  /// leaves with one value are one.
  template <class Visit>
  void for_all(const Visit& visit) const {
    Draft draft;
    unpack(draft);
    visit_below(draft, 0, kBits, visit);
  }
  /// Of the octree, inner ones and leaves.
  std::size_t nodes() const;
  /// Of the bricks that are not in `seen` yet.
  std::size_t bytes(std::set<const void*>& seen) const;

  void save(OutArchive& out) const;
  /// Throws DataError if what is read is not a valid octree.
  void load(InArchive& in);

 private:
  static constexpr std::size_t kBricks = kVoxels / VoxelBrick::kVoxels;

  static std::size_t spread(std::int32_t coordinate) {
    static constexpr std::array<std::uint16_t, kSide> kSpread = [] {
      std::array<std::uint16_t, kSide> table{};
      for (unsigned i = 0; i < kSide; ++i) {
        for (unsigned bit = 0; bit < kBits; ++bit)
          table[i] = static_cast<std::uint16_t>(table[i] | ((i >> bit) & 1u) << (3 * bit));
      }
      return table;
    }();
    return kSpread[static_cast<std::size_t>(coordinate & (kSide - 1))];
  }
  static LocalVoxel voxel_at(std::size_t place);
  /// All 8^level voxels from `first` on are known and have one value.
  static bool is_one(const Draft& draft, std::size_t first, int level);
  static bool is_unknown(const Draft& draft, std::size_t first, int level);
  static std::size_t nodes_below(const Draft& draft, std::size_t first, int level);
  template <class Visit>
  static void visit_below(const Draft& draft, std::size_t first, int level, const Visit& visit) {
    if (is_unknown(draft, first, level)) return;
    if (is_one(draft, first, level)) {
      visit(voxel_at(first), 1 << level, draft.odds[first]);
      return;
    }
    for (std::size_t i = 0; i < 8; ++i) visit_below(draft, first + (i << (3 * (level - 1))), level - 1, visit);
  }

  bool is_whole(std::size_t brick) const { return (whole_ >> brick & 1u) != 0; }
  void set(std::size_t brick, const BrickDraft& draft);
  void unpack(Draft& draft) const;
  /// The blocks of a brick; `room` is where they are put if there is no such brick.
  const VoxelBrick::Blocks& blocks(std::size_t brick, VoxelBrick::Blocks& room) const;
  const float* values(std::size_t brick) const { return bricks_[brick] ? bricks_[brick].values() : nullptr; }

  std::array<VoxelBrick, kBricks> bricks_;      // none: unknown, or whole
  std::array<float, kBricks> whole_odds_ = {};  // of those bricks that are one leaf
  std::uint8_t whole_ = 0;                      // one bit a brick
};

}  // namespace waymark::octomap_grid
