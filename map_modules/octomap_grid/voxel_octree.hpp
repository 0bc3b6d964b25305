// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <octomap/OcTreeDataNode.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "scan_settings.hpp"
#include "waymark/archive.hpp"

namespace waymark::octo {

struct VoxelOctet;

/// A node of OctoMap's octrees (A. Hornung et al., Autonomous Robots, 2013): natural log-odds of occupancy, and eight
/// places for children. A leaf above the last level stands for all voxels below it.
class VoxelNode : public octomap::OcTreeDataNode<float> {
 public:
  VoxelNode() : OcTreeDataNode(0.0f) {}
  VoxelNode(const VoxelNode&) = delete;
  VoxelNode& operator=(const VoxelNode&) = delete;

  bool is_leaf() const { return children == nullptr; }
  /// Null: that child is unknown, or this is a leaf.
  const VoxelNode* child(std::size_t i) const {
    return children == nullptr ? nullptr : static_cast<const VoxelNode*>(children[i]);
  }

 private:
  friend class VoxelOctree;
};

/// What all of an octree's voxels are updated by: natural log-odds.
struct VoxelOdds {
  explicit VoxelOdds(const grid::OddsSettings& s)
      : hit(static_cast<float>(s.hit / grid::OddsSettings::kSteps)),
        miss(static_cast<float>(s.miss / grid::OddsSettings::kSteps)),
        low(static_cast<float>(s.low / grid::OddsSettings::kSteps)),
        high(static_cast<float>(s.high / grid::OddsSettings::kSteps)) {}
  float after_hit(float odds) const { return odds + hit < high ? odds + hit : high; }
  float after_miss(float odds) const { return odds + miss > low ? odds + miss : low; }

  float hit;
  float miss;
  float low;
  float high;
};

/// A voxel of one octree, 0 … kSide − 1 in each direction.
struct LocalVoxel {
  std::uint8_t x = 0;
  std::uint8_t y = 0;
  std::uint8_t z = 0;
};

/// Occupancy of a cube of 16 × 16 × 16 voxels as a shallow octree with OctoMap's nodes. No octomap::OcTree: each of
/// those holds a buffer for rays of 600 kB, which a copy fills anew. And no node has memory of its own: the eight
/// children of one lie together, so that a copy takes one allocation where OctoMap takes nine.
class VoxelOctree {
 public:
  static constexpr int kBits = 4;
  static constexpr int kSide = 1 << kBits;
  static constexpr std::size_t kVoxels = std::size_t{1} << (3 * kBits);

  /// One bit a voxel, in the order of the octree's leaves.
  using Bits = std::array<std::uint64_t, kVoxels / 64>;
  /// What one scan says about the voxels; none is in both.
  struct Marks {
    Bits free{};
    Bits hit{};
  };
  /// Place of a voxel in `Bits`; only the last four bits of each count.
  static std::size_t place(std::int32_t x, std::int32_t y, std::int32_t z) {
    return spread(x) | spread(y) << 1 | spread(z) << 2;
  }

  VoxelOctree() = default;
  VoxelOctree(const VoxelOctree& other);
  VoxelOctree(VoxelOctree&& other) noexcept;
  VoxelOctree& operator=(VoxelOctree other) noexcept;
  ~VoxelOctree();

  bool is_unknown() const { return !known_; }
  /// Null if all is unknown.
  const VoxelNode* root() const { return known_ ? &root_ : nullptr; }
  /// Log-odds of a voxel, or null if it is unknown.
  const float* find(LocalVoxel voxel) const;
  /// True if `apply` would change anything.
  bool would_change(const Marks& marks, const VoxelOdds& odds) const;
  /// Updates every marked voxel once; appends those that became occupied, and those that no longer are. Eight leaves
  /// with one value become one.
  void apply(const Marks& marks, const VoxelOdds& odds, std::vector<LocalVoxel>& occupied,
             std::vector<LocalVoxel>& freed);
  /// Gives the cube of 2^level voxels in each direction around `voxel` one value. It must be unknown so far.
  void set(LocalVoxel voxel, int level, float odds);

  /// Calls visit(LocalVoxel of the lowest corner, side in voxels, log-odds) for all leaves, in a fixed order.
  template <class Visit>
  void for_all(const Visit& visit) const {
    if (known_) visit_below(root_, kBits, {}, visit);
  }
  std::size_t nodes() const;
  std::size_t bytes() const { return octets_ * kOctetBytes; }

  void save(OutArchive& out) const;
  /// Throws DataError if what is read is no such octree.
  void load(InArchive& in);

  static bool is_occupied(float odds) { return odds > 0.0f; }

 private:
  static const std::size_t kOctetBytes;
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
  struct Scan;
  struct Changes;

  void swap(VoxelOctree& other) noexcept;
  VoxelOctet* octet_of(const VoxelNode& node) const { return reinterpret_cast<VoxelOctet*>(node.children); }
  VoxelNode& create_child(VoxelNode& node, std::size_t i);
  void expand(VoxelNode& node);
  void prune(VoxelNode& node);
  void copy(const VoxelNode& from, VoxelNode& to);
  void clear(VoxelNode& node);
  template <int L>
  void update(VoxelNode& node, bool is_new, std::size_t first, const Scan& scan, Changes& changed);
  template <int L>
  static bool changes(const VoxelNode* node, std::size_t first, const Scan& scan);
  static void save_below(const VoxelNode& node, OutArchive& out);
  void load_below(VoxelNode& node, int level, InArchive& in);
  template <class Visit>
  static void visit_below(const VoxelNode& node, int level, LocalVoxel at, const Visit& visit) {
    if (node.is_leaf()) {
      visit(at, 1 << level, node.getValue());
      return;
    }
    const int half = 1 << (level - 1);
    const auto plus = [](std::uint8_t a, int b) { return static_cast<std::uint8_t>(a + b); };
    for (std::size_t i = 0; i < 8; ++i) {
      const VoxelNode* child = node.child(i);
      if (child == nullptr) continue;
      const LocalVoxel corner{(i & 1) != 0 ? plus(at.x, half) : at.x, (i & 2) != 0 ? plus(at.y, half) : at.y,
                              (i & 4) != 0 ? plus(at.z, half) : at.z};
      visit_below(*child, level - 1, corner, visit);
    }
  }

  VoxelNode root_;
  bool known_ = false;
  std::uint32_t octets_ = 0;
};

}  // namespace waymark::octo
