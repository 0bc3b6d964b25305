// SPDX-License-Identifier: Apache-2.0
#pragma once

// How a tree of tiles is written into a checkpoint and read back. Nodes and tiles that several trees share are written
// once.
#include <string>

#include "waymark/base/error.hpp"
#include "waymark/memory/shared_archive.hpp"

namespace waymark::scan_matching {

namespace shared_tree {

enum class Kind : std::uint8_t { kEmpty = 0, kTile = 1, kNode = 2 };
constexpr Kind last_of(Kind /*kind*/) { return Kind::kNode; }

inline void require(bool is_right, const char* what) {
  if (!is_right) throw DataError(std::string("checkpoint: tiles: ") + what);
}

}  // namespace shared_tree

/// A slot as read.
template <class Tile>
struct SharedTree<Tile>::Loaded {
  Slot slot;
  int height = 0;
};

template <class Tile>
void SharedTree<Tile>::save(OutArchive& out) const {
  out.section("tiles", 1);
  out.value(static_cast<std::int32_t>(height_));
  out.value(prefix_.x);
  out.value(prefix_.y);
  save_slot(root_, out);
}

template <class Tile>
void SharedTree<Tile>::save_slot(const Slot& slot, OutArchive& out) {
  using shared_tree::Kind;
  if (std::holds_alternative<std::monostate>(slot)) {
    out.value(Kind::kEmpty);
    return;
  }
  const auto* tile = std::get_if<Cow<Tile>>(&slot);
  out.value(tile != nullptr ? Kind::kTile : Kind::kNode);
  save_shared(identity(slot), out, [&] {
    if (tile != nullptr) {
      out(tile->read());
      return;
    }
    for (const Slot& child : std::get<Cow<Node>>(slot)->children) save_slot(child, out);
  });
}

template <class Tile>
void SharedTree<Tile>::load(InArchive& in) {
  in.section("tiles", 1);
  std::int32_t height = 0;
  in.within(height, 0, kMaxHeight);
  in.value(prefix_.x);
  in.value(prefix_.y);
  const Key beyond = prefix_.above(kMaxHeight - height);
  shared_tree::require(beyond == Key{}, "a tree beyond all places");
  height_ = height;
  root_ = load_slot(in, height).slot;
  std::set<const void*> seen;
  require_tree(root_, height_, prefix_, seen);
}

template <class Tile>
void SharedTree<Tile>::require_tree(const Slot& slot, int height, Key prefix, std::set<const void*>& seen) {
  const void* const id = identity(slot);
  if (id == nullptr) return;
  // A tree that held itself several times would take for ever to visit.
  shared_tree::require(seen.insert(id).second, "a node that stands in two places");
  if (const auto* node = std::get_if<Cow<Node>>(&slot)) {
    for (std::size_t child = 0; child < std::size_t{kFan} * kFan; ++child)
      require_tree((*node)->children[child], height - 1, prefix.below(child), seen);
    return;
  }
  const TileIndex index = index_of(prefix);
  const auto is_near = [](std::int32_t i) { return i >= -kMaxIndex && i <= kMaxIndex; };
  shared_tree::require(is_near(index.x) && is_near(index.y), "a tile beyond all places");
}

template <class Tile>
typename SharedTree<Tile>::Loaded SharedTree<Tile>::load_slot(InArchive& in, int height) {
  using shared_tree::Kind;
  Kind kind = Kind::kEmpty;
  in.value(kind);
  if (kind == Kind::kEmpty) return {{}, height};
  shared_tree::require(kind == (height == 0 ? Kind::kTile : Kind::kNode), "a node at the wrong height");
  Loaded loaded = load_shared<Loaded>(in, [&]() -> Loaded {
    if (height == 0) {
      Cow<Tile> tile;
      in(tile.write());
      return {std::move(tile), height};
    }
    Node node;
    for (Slot& child : node.children) child = load_slot(in, height - 1).slot;
    return {Cow<Node>(std::move(node)), height};
  });
  shared_tree::require(loaded.height == height, "a node at the wrong height");
  return loaded;
}

}  // namespace waymark::scan_matching
