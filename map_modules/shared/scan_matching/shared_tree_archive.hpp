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
  in.value(height);
  in.value(prefix_.x);
  in.value(prefix_.y);
  shared_tree::require(height >= 0 && height <= kMaxHeight, "a tree of no possible height");
  height_ = height;
  root_ = load_slot(in, height).slot;
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
