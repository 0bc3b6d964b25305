// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cassert>
#include <set>

namespace waymark::scan_matching {

template <class Tile>
const void* SharedTree<Tile>::identity(const Slot& slot) {
  if (const auto* tile = std::get_if<Cow<Tile>>(&slot)) return tile->identity();
  if (const auto* node = std::get_if<Cow<Node>>(&slot)) return node->identity();
  return nullptr;
}

template <class Tile>
const Tile& SharedTree<Tile>::read(TileIndex index) const {
  const Key key = key_of(index);
  if (key.above(height_) != prefix_) return empty_tile();
  const Slot* slot = &root_;
  for (int level = height_; level > 0; --level) {
    const auto* node = std::get_if<Cow<Node>>(slot);
    if (node == nullptr) return empty_tile();
    slot = &(*node)->children[key.above(level - 1).child()];
  }
  const auto* tile = std::get_if<Cow<Tile>>(slot);
  return tile == nullptr ? empty_tile() : tile->read();
}

template <class Tile>
Tile& SharedTree<Tile>::write(TileIndex index) {
  assert(std::abs(index.x) <= kMaxIndex && std::abs(index.y) <= kMaxIndex);
  const Key key = key_of(index);
  if (std::holds_alternative<std::monostate>(root_)) {
    height_ = 0;
    prefix_ = key;
  }
  while (key.above(height_) != prefix_) {
    Node above;
    above.children[prefix_.child()] = std::move(root_);
    root_ = Cow<Node>(std::move(above));
    prefix_ = prefix_.above(1);
    ++height_;
  }
  Slot* slot = &root_;
  for (int level = height_; level > 0; --level) {
    if (std::holds_alternative<std::monostate>(*slot)) *slot = Cow<Node>();
    slot = &std::get<Cow<Node>>(*slot).write().children[key.above(level - 1).child()];
  }
  if (std::holds_alternative<std::monostate>(*slot)) *slot = Cow<Tile>();
  return std::get<Cow<Tile>>(*slot).write();
}

template <class Tile>
void SharedTree<Tile>::gather_below(const Slot& slot, int height, Key prefix, const TileRect& rect,
                                    std::span<const Tile*> out) {
  // The block of tiles below this slot, cut to the rectangle; 64 bits, since a block may reach beyond all indices.
  const std::int64_t side = std::int64_t{1} << (kFanBits * height);
  const auto first = [&](std::uint32_t digits) { return static_cast<std::int64_t>(digits) * side - kMiddle; };
  const std::int64_t x0 = std::max<std::int64_t>(first(prefix.x), rect.low.x);
  const std::int64_t y0 = std::max<std::int64_t>(first(prefix.y), rect.low.y);
  const std::int64_t x1 = std::min<std::int64_t>(first(prefix.x) + side - 1, rect.high.x);
  const std::int64_t y1 = std::min<std::int64_t>(first(prefix.y) + side - 1, rect.high.y);
  if (x0 > x1 || y0 > y1) return;
  if (const auto* tile = std::get_if<Cow<Tile>>(&slot)) {
    out[static_cast<std::size_t>((y0 - rect.low.y) * rect.width() + (x0 - rect.low.x))] = &tile->read();
  } else if (const auto* node = std::get_if<Cow<Node>>(&slot)) {
    const std::int64_t part = side / kFan;
    const auto digit = [&](std::int64_t index, std::uint32_t digits) { return (index - first(digits)) / part; };
    const std::int64_t first_x = digit(x0, prefix.x);
    const std::int64_t last_x = digit(x1, prefix.x);
    for (std::int64_t y = digit(y0, prefix.y); y <= digit(y1, prefix.y); ++y) {
      for (std::int64_t x = first_x; x <= last_x; ++x) {
        const auto child = static_cast<std::size_t>(y * kFan + x);
        const Slot& below = (*node)->children[child];
        if (std::holds_alternative<std::monostate>(below)) continue;
        gather_below(below, height - 1, prefix.below(child), rect, out);
      }
    }
  }
}

template <class Tile>
void SharedTree<Tile>::gather(const TileRect& rect, std::span<const Tile*> out) const {
  std::fill(out.begin(), out.end(), &empty_tile());
  gather_below(root_, height_, prefix_, rect, out);
}

template <class Tile>
std::size_t SharedTree<Tile>::tiles() const {
  std::size_t count = 0;
  for_all([&](TileIndex, const Tile&, bool) { ++count; });
  return count;
}

template <class Tile>
std::size_t SharedTree<Tile>::bytes_of(std::span<const SharedTree* const> trees) {
  std::set<const void*> seen;
  std::size_t bytes = 0;
  const auto add = [&](const auto& self, const Slot& slot) -> void {
    const void* const id = identity(slot);
    if (id == nullptr || !seen.insert(id).second) return;
    const auto* node = std::get_if<Cow<Node>>(&slot);
    bytes += node == nullptr ? std::get<Cow<Tile>>(slot)->bytes(seen) : sizeof(Node);
    if (node == nullptr) return;
    for (const Slot& child : (*node)->children) self(self, child);
  };
  for (const SharedTree* tree : trees) add(add, tree->root_);
  return bytes;
}

template <class Tile>
void SharedTree<Tile>::describe_memory(std::span<const SharedTree* const> trees, std::vector<MapFigure>& out) {
  std::size_t deep = 0;
  for (std::size_t i = 0; i < trees.size(); ++i) deep += bytes_of(trees.subspan(i, 1));
  out.push_back({"memory_all_bytes", static_cast<double>(bytes_of(trees))});
  out.push_back({"memory_deep_bytes", static_cast<double>(deep)});
}

}  // namespace waymark::scan_matching
