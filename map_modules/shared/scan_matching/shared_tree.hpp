// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <set>
#include <span>
#include <type_traits>
#include <variant>
#include <vector>

#include "map_modules/shared/scan_matching/cell.hpp"
#include "waymark/interface/particle_map.hpp"
#include "waymark/io/archive.hpp"
#include "waymark/memory/cow.hpp"

namespace waymark::scan_matching {

/// A particle's tiles in a tree of 8 × 8 children a node, shared between particles until one of them writes (path
/// copying: J. Driscoll et al., JCSS 1989). Copying the tree copies one handle, whatever its size; `write` clones at
/// most the nodes between the root and one tile. The tree grows in all directions as tiles are written, and upwards
/// with it.
///
/// A `Tile` is what covers a square of the plane. It has `save(OutArchive&) const`, `load(InArchive&)`, and
/// `bytes(seen) const`: its size without what it shares with those whose parts are in the set `seen`.
template <class Tile>
class SharedTree {
 public:
  static constexpr int kFanBits = 3;
  static constexpr int kFan = 1 << kFanBits;  ///< children of a node, along one side
  static constexpr std::int32_t kMaxIndex = TileIndex::kMost;

  /// The tile of places that were never written.
  static const Tile& empty_tile() {
    static const Tile tile;
    return tile;
  }
  /// The tile, or `empty_tile()`.
  const Tile& read(TileIndex index) const;
  /// The tile for writing; cloned first if others share it, made if it is not there. Stays where it is until this tree
  /// is copied. `index` must be within kMaxIndex.
  Tile& write(TileIndex index);
  /// The tiles of a rectangle, row by row; `empty_tile()` where there is none. `out` has rect.size() places.
  void gather(const TileRect& rect, std::span<const Tile*> out) const;
  /// Calls visit(index, tile, is_shared) for all tiles in a fixed order; shared: another tree holds it, too.
  template <class Visit>
  void for_all(const Visit& visit) const {
    visit_below(root_, height_, prefix_, false, visit);
  }

  bool empty() const { return std::holds_alternative<std::monostate>(root_); }
  std::size_t tiles() const;
  int height() const { return height_; }
  bool shares_root_with(const SharedTree& other) const { return identity(root_) == identity(other.root_); }
  /// Bytes of the tiles and nodes of these trees, each shared one counted once.
  static std::size_t bytes_of(std::span<const SharedTree* const> trees);
  /// The figures `memory_all_bytes`, of all trees together, and `memory_deep_bytes`, if each were a copy of its own.
  static void describe_memory(std::span<const SharedTree* const> trees, std::vector<MapFigure>& out);

  void save(OutArchive& out) const;
  /// Throws DataError if what is read is not a valid tree.
  void load(InArchive& in);

 private:
  struct Node;
  using Slot = std::variant<std::monostate, Cow<Tile>, Cow<Node>>;
  struct Node {
    std::array<Slot, std::size_t{kFan} * kFan> children;
  };
  static_assert(!std::is_empty_v<Node>);  // the node first, then slots: a variant of the other order does not compile
  /// An index as digits of base 8, the origin in the middle of its block on every level, so that a map about the origin
  /// stays low.
  struct Key {
    std::uint32_t x = 0;
    std::uint32_t y = 0;

    bool operator==(const Key&) const = default;
    Key above(int levels) const { return {x >> (kFanBits * levels), y >> (kFanBits * levels)}; }
    std::size_t child() const { return std::size_t{(y & (kFan - 1)) * kFan + (x & (kFan - 1))}; }
    Key below(std::size_t child) const {
      return {x * kFan + static_cast<std::uint32_t>(child % kFan), y * kFan + static_cast<std::uint32_t>(child / kFan)};
    }
  };
  struct Loaded;

  static constexpr std::uint32_t kMiddle = 04444444444;  // octal
  static constexpr int kMaxHeight = 10;
  static Key key_of(TileIndex index) {
    return {static_cast<std::uint32_t>(index.x) + kMiddle, static_cast<std::uint32_t>(index.y) + kMiddle};
  }
  static TileIndex index_of(Key key) {
    return {static_cast<std::int32_t>(key.x - kMiddle), static_cast<std::int32_t>(key.y - kMiddle)};
  }
  static const void* identity(const Slot& slot);
  template <class Visit>
  static void visit_below(const Slot& slot, int height, Key prefix, bool is_shared, const Visit& visit);
  static void gather_below(const Slot& slot, int height, Key prefix, const TileRect& rect, std::span<const Tile*> out);
  static void save_slot(const Slot& slot, OutArchive& out);
  static Loaded load_slot(InArchive& in, int height);
  static void require_tree(const Slot& slot, int height, Key prefix, std::set<const void*>& seen);

  Slot root_;
  int height_ = 0;  // levels of nodes above the tiles
  Key prefix_;      // of all tiles below the root
};

template <class Tile>
template <class Visit>
void SharedTree<Tile>::visit_below(const Slot& slot, int height, Key prefix, bool is_shared, const Visit& visit) {
  if (const auto* tile = std::get_if<Cow<Tile>>(&slot)) {
    visit(index_of(prefix), tile->read(), is_shared || tile->is_shared());
  } else if (const auto* node = std::get_if<Cow<Node>>(&slot)) {
    for (std::size_t child = 0; child < std::size_t{kFan} * kFan; ++child)
      visit_below((*node)->children[child], height - 1, prefix.below(child), is_shared || node->is_shared(), visit);
  }
}

}  // namespace waymark::scan_matching

// The definitions of the members above.
#include "map_modules/shared/scan_matching/shared_tree_archive.hpp"
#include "map_modules/shared/scan_matching/shared_tree_impl.hpp"
