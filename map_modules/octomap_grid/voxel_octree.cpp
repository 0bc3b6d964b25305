// SPDX-License-Identifier: Apache-2.0
#include "voxel_octree.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "waymark/error.hpp"

namespace waymark::octo {

/// The children of one node, and OctoMap's table of them; absent ones are null there.
struct VoxelOctet {
  std::array<octomap::AbstractOcTreeNode*, 8> child{};
  std::array<VoxelNode, 8> node;
};

const std::size_t VoxelOctree::kOctetBytes = sizeof(VoxelOctet);

namespace {

/// The leaf's place in the octree's order, taken apart again.
LocalVoxel voxel_at(std::size_t place) {
  LocalVoxel voxel;
  for (int bit = 0; bit < VoxelOctree::kBits; ++bit) {
    voxel.x = static_cast<std::uint8_t>(voxel.x | ((place >> (3 * bit)) & 1) << bit);
    voxel.y = static_cast<std::uint8_t>(voxel.y | ((place >> (3 * bit + 1)) & 1) << bit);
    voxel.z = static_cast<std::uint8_t>(voxel.z | ((place >> (3 * bit + 2)) & 1) << bit);
  }
  return voxel;
}

/// Which voxels are marked, and quickly whether any is in a cube of the octree: those of level L and beginning at
/// `first` are the bits [first, first + 8^L).
class Marked {
 public:
  explicit Marked(const VoxelOctree::Bits& bits) : bits_(bits) {
    for (std::size_t i = 0; i < bits.size(); ++i) words_ |= std::uint64_t{bits[i] != 0} << i;
  }
  template <int L>
  bool any(std::size_t first) const {
    if constexpr (L == 0) return (bits_[first >> 6] >> (first & 63) & 1u) != 0;
    if constexpr (L == 1) return (bits_[first >> 6] >> (first & 63) & 0xffu) != 0;
    if constexpr (L == 2) return (words_ >> (first >> 6) & 1u) != 0;
    if constexpr (L == 3) return (words_ >> (first >> 6) & 0xffu) != 0;
    return words_ != 0;
  }
  template <int L>
  bool all(std::size_t first) const {
    if constexpr (L == 0) return any<0>(first);
    if constexpr (L == 1) return (bits_[first >> 6] >> (first & 63) & 0xffu) == 0xffu;
    constexpr std::size_t kWords = std::size_t{1} << (3 * std::max(L - 2, 0));
    for (std::size_t i = first >> 6; i < (first >> 6) + kWords; ++i) {
      if (bits_[i] != ~std::uint64_t{0}) return false;
    }
    return true;
  }

 private:
  const VoxelOctree::Bits& bits_;
  std::uint64_t words_ = 0;  // which of them are not zero
};
static_assert(VoxelOctree::kBits == 4, "64 words, a bit for each");

std::size_t child_first(std::size_t first, int level, std::size_t i) { return first + (i << (3 * (level - 1))); }

}  // namespace

struct VoxelOctree::Scan {
  Scan(const Marks& marks, const VoxelOdds& o) : free(marks.free), hit(marks.hit), odds(o) {}
  template <int L>
  bool any(std::size_t first) const {
    return free.any<L>(first) || hit.any<L>(first);
  }
  Marked free;
  Marked hit;
  const VoxelOdds& odds;
};

struct VoxelOctree::Changes {
  std::vector<LocalVoxel>& occupied;
  std::vector<LocalVoxel>& freed;
};

VoxelOctree::VoxelOctree(const VoxelOctree& other) : known_(other.known_) { copy(other.root_, root_); }

VoxelOctree::VoxelOctree(VoxelOctree&& other) noexcept { swap(other); }

VoxelOctree& VoxelOctree::operator=(VoxelOctree other) noexcept {
  swap(other);
  return *this;
}

void VoxelOctree::swap(VoxelOctree& other) noexcept {
  std::swap(root_.children, other.root_.children);
  std::swap(root_.value, other.root_.value);
  std::swap(known_, other.known_);
  std::swap(octets_, other.octets_);
}

VoxelOctree::~VoxelOctree() { clear(root_); }

void VoxelOctree::copy(const VoxelNode& from, VoxelNode& to) {
  to.value = from.value;
  if (from.is_leaf()) return;
  auto* octet = new VoxelOctet;
  ++octets_;
  to.children = octet->child.data();
  for (std::size_t i = 0; i < 8; ++i) {
    const VoxelNode* child = from.child(i);
    if (child == nullptr) continue;
    octet->child[i] = &octet->node[i];
    copy(*child, octet->node[i]);
  }
}

void VoxelOctree::clear(VoxelNode& node) {
  if (node.is_leaf()) return;
  VoxelOctet* octet = octet_of(node);
  for (VoxelNode& child : octet->node) clear(child);
  delete octet;
  --octets_;
  node.children = nullptr;
}

VoxelNode& VoxelOctree::create_child(VoxelNode& node, std::size_t i) {
  if (node.is_leaf()) {
    node.children = (new VoxelOctet)->child.data();
    ++octets_;
  }
  VoxelOctet* octet = octet_of(node);
  octet->child[i] = &octet->node[i];
  return octet->node[i];
}

void VoxelOctree::expand(VoxelNode& node) {
  for (std::size_t i = 0; i < 8; ++i) create_child(node, i).value = node.value;
}

void VoxelOctree::prune(VoxelNode& node) {
  const VoxelOctet* octet = octet_of(node);
  for (std::size_t i = 0; i < 8; ++i) {
    const VoxelNode* child = node.child(i);
    if (child == nullptr || !child->is_leaf() || child->value != octet->node[0].value) return;
  }
  node.value = octet->node[0].value;
  clear(node);
}

/// Some voxel of the node's is marked.
template <int L>
bool VoxelOctree::changes(const VoxelNode* node, std::size_t first, const Scan& scan) {
  if (node == nullptr) return true;
  if (node->is_leaf()) {
    const float v = node->value;
    return (scan.free.any<L>(first) && scan.odds.after_miss(v) != v) ||
           (scan.hit.any<L>(first) && scan.odds.after_hit(v) != v);
  }
  if constexpr (L > 0) {
    for (std::size_t i = 0; i < 8; ++i) {
      const std::size_t from = child_first(first, L, i);
      if (scan.any<L - 1>(from) && changes<L - 1>(node->child(i), from, scan)) return true;
    }
  }
  return false;
}

bool VoxelOctree::would_change(const Marks& marks, const VoxelOdds& odds) const {
  const Scan scan(marks, odds);
  return scan.any<kBits>(0) && changes<kBits>(root(), 0, scan);
}

/// Some voxel of the node's is marked. `is_new`: nothing was known of it so far; it has no children, and its value is
/// 0.
template <int L>
void VoxelOctree::update(VoxelNode& node, bool is_new, std::size_t first, const Scan& scan, Changes& changed) {
  if (node.is_leaf()) {
    const bool free = scan.free.any<L>(first);
    const bool hit = scan.hit.any<L>(first);
    const float before = node.value;
    if (L == 0 || (!hit && scan.free.all<L>(first)) || (!free && scan.hit.all<L>(first))) {  // all of it as one
      node.value = hit ? scan.odds.after_hit(before) : scan.odds.after_miss(before);
      if (is_occupied(before) == is_occupied(node.value)) return;
      for (std::size_t i = first; i < first + (std::size_t{1} << (3 * L)); ++i)
        (is_occupied(node.value) ? changed.occupied : changed.freed).push_back(voxel_at(i));
      return;
    }
    if (!is_new) {
      const bool is_at_its_bound =
          (!free || scan.odds.after_miss(before) == before) && (!hit || scan.odds.after_hit(before) == before);
      if (is_at_its_bound) return;
      expand(node);
    }
  }
  if constexpr (L > 0) {
    for (std::size_t i = 0; i < 8; ++i) {
      const std::size_t from = child_first(first, L, i);
      if (!scan.any<L - 1>(from)) continue;
      const bool is_new_child = node.child(i) == nullptr;
      VoxelNode& child = is_new_child ? create_child(node, i) : octet_of(node)->node[i];
      update<L - 1>(child, is_new_child, from, scan, changed);
    }
    prune(node);
  }
}

void VoxelOctree::apply(const Marks& marks, const VoxelOdds& odds, std::vector<LocalVoxel>& occupied,
                        std::vector<LocalVoxel>& freed) {
  const Scan scan(marks, odds);
  if (!scan.any<kBits>(0)) return;
  Changes changed{occupied, freed};
  update<kBits>(root_, !std::exchange(known_, true), 0, scan, changed);
}

const float* VoxelOctree::find(LocalVoxel voxel) const {
  const VoxelNode* node = root();
  const std::size_t at = place(voxel.x, voxel.y, voxel.z);
  for (int level = kBits; node != nullptr && !node->is_leaf(); --level) node = node->child(at >> (3 * (level - 1)) & 7);
  return node == nullptr ? nullptr : &node->value;
}

void VoxelOctree::set(LocalVoxel voxel, int level, float odds) {
  VoxelNode* node = &root_;
  const std::size_t at = place(voxel.x, voxel.y, voxel.z);
  known_ = true;
  for (int l = kBits; l > level; --l) {
    const std::size_t i = at >> (3 * (l - 1)) & 7;
    node = node->child(i) == nullptr ? &create_child(*node, i) : &octet_of(*node)->node[i];
  }
  node->value = odds;
}

std::size_t VoxelOctree::nodes() const {
  if (!known_) return 0;
  const auto count = [](const auto& self, const VoxelNode& node) -> std::size_t {
    std::size_t sum = 1;
    for (std::size_t i = 0; i < 8; ++i) {
      if (const VoxelNode* child = node.child(i)) sum += self(self, *child);
    }
    return sum;
  };
  return count(count, root_);
}

void VoxelOctree::save_below(const VoxelNode& node, OutArchive& out) {
  std::uint8_t mask = 0;
  for (unsigned i = 0; i < 8; ++i) {
    if (node.child(i) != nullptr) mask = static_cast<std::uint8_t>(mask | 1u << i);
  }
  out.value(mask);
  if (mask == 0) out.value(node.value);
  for (std::size_t i = 0; i < 8; ++i) {
    if (const VoxelNode* child = node.child(i)) save_below(*child, out);
  }
}

void VoxelOctree::load_below(VoxelNode& node, int level, InArchive& in) {
  std::uint8_t mask = 0;
  in.value(mask);
  if (mask == 0) {
    in.value(node.value);
    if (!std::isfinite(node.value)) throw DataError("checkpoint: octree: log-odds that are not finite");
    return;
  }
  if (level == 0) throw DataError("checkpoint: octree: deeper than it can be");
  for (unsigned i = 0; i < 8; ++i) {
    if ((mask >> i & 1u) != 0) load_below(create_child(node, i), level - 1, in);
  }
}

void VoxelOctree::save(OutArchive& out) const {
  out.value(known_);
  if (known_) save_below(root_, out);
}

void VoxelOctree::load(InArchive& in) {
  VoxelOctree loaded;
  in.value(loaded.known_);
  if (loaded.known_) loaded.load_below(loaded.root_, kBits, in);
  *this = std::move(loaded);
}

}  // namespace waymark::octo
