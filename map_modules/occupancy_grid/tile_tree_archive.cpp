// SPDX-License-Identifier: Apache-2.0
// How a tree of tiles is written into a checkpoint and read back. Nodes and tiles that several trees share are written
// once.
#include <memory>
#include <string>

#include "tile_tree.hpp"
#include "waymark/error.hpp"

namespace waymark::grid {

namespace {

enum class Kind : std::uint8_t { kEmpty = 0, kTile = 1, kNode = 2 };

void require(bool is_right, const char* what) {
  if (!is_right) throw DataError(std::string("checkpoint: tiles: ") + what);
}

}  // namespace

/// A slot as read.
struct TileTree::Loaded {
  Slot slot;
  int height = 0;
};

void TileTree::save(OutArchive& out) const {
  out.section("tiles", 1);
  out.value(static_cast<std::int32_t>(height_));
  out.value(prefix_.x);
  out.value(prefix_.y);
  save_slot(root_, out);
}

void TileTree::save_slot(const Slot& slot, OutArchive& out) {
  if (std::holds_alternative<std::monostate>(slot)) {
    out.value(Kind::kEmpty);
    return;
  }
  const auto* tile = std::get_if<Cow<Tile>>(&slot);
  out.value(tile != nullptr ? Kind::kTile : Kind::kNode);
  if (!out.first_sight(identity(slot))) return;
  if (tile != nullptr) {
    out.bytes((*tile)->odds.data(), Tile::kCells);
    out.bytes((*tile)->distance.data(), Tile::kCells);
    return;
  }
  for (const Slot& child : std::get<Cow<Node>>(slot)->children) save_slot(child, out);
}

void TileTree::load(InArchive& in) {
  in.section("tiles", 1);
  std::int32_t height = 0;
  in.value(height);
  in.value(prefix_.x);
  in.value(prefix_.y);
  require(height >= 0 && height <= kMaxHeight, "a tree of no possible height");
  height_ = height;
  root_ = load_slot(in, height).slot;
}

TileTree::Loaded TileTree::load_slot(InArchive& in, int height) {
  Kind kind = Kind::kEmpty;
  in.value(kind);
  Loaded loaded;
  loaded.height = height;
  if (kind == Kind::kEmpty) return loaded;
  require(kind == (height == 0 ? Kind::kTile : Kind::kNode), "a node at the wrong height");
  std::uint64_t number = 0;
  if (const auto known = in.shared(number)) {
    loaded = *std::static_pointer_cast<Loaded>(known);
    require(loaded.height == height, "a node at the wrong height");
    return loaded;
  }
  if (height == 0) {
    Cow<Tile> tile;
    in.bytes(tile.write().odds.data(), Tile::kCells);
    in.bytes(tile.write().distance.data(), Tile::kCells);
    loaded.slot = std::move(tile);
  } else {
    Node node;
    for (Slot& child : node.children) child = load_slot(in, height - 1).slot;
    loaded.slot = Cow<Node>(std::move(node));
  }
  in.remember(number, std::make_shared<Loaded>(loaded));
  return loaded;
}

}  // namespace waymark::grid
