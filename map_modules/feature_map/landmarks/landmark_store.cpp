// SPDX-License-Identifier: Apache-2.0
#include "map_modules/feature_map/landmarks/landmark_store.hpp"

#include <algorithm>
#include <numeric>
#include <unordered_set>

#include "waymark/base/error.hpp"

namespace waymark::feature_map {

namespace {

/// Of `count` indices in order of `key`, the first half; ties by index, so that the order is total.
template <std::size_t N, class Key>
std::array<bool, N> lower_half(const Key& key) {
  std::array<std::size_t, N> order;
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, [&](std::size_t a, std::size_t b) { return key(a) != key(b) ? key(a) < key(b) : a < b; });
  std::array<bool, N> is_lower{};
  for (std::size_t i = 0; i < N / 2; ++i) is_lower[order[i]] = true;
  return is_lower;
}

}  // namespace

LandmarkBox LandmarkStore::Inner::box() const {
  LandmarkBox box;
  for (const LandmarkBox& child : boxes) box.include(child);
  return box;
}

bool LandmarkStore::Inner::is_empty() const {
  return std::ranges::all_of(children, [](const Node& child) { return child.index() == 0; });
}

const void* LandmarkStore::identity(const Node& node) {
  if (const auto* leaf = std::get_if<Cow<LandmarkLeaf>>(&node)) return leaf->identity();
  if (const auto* inner = std::get_if<Cow<Inner>>(&node)) return inner->identity();
  return nullptr;
}

const LandmarkLeaf& LandmarkStore::leaf_of(LandmarkRef ref) const {
  const Node* node = &root_;
  for (int height = height_; height > 0; --height)
    node = &std::get<Cow<Inner>>(*node)->children[static_cast<std::size_t>(slot_of(ref.chunk, height))];
  return std::get<Cow<LandmarkLeaf>>(*node).read();
}

LandmarkLeaf& LandmarkStore::leaf_for_writing(LandmarkRef ref) {
  Node* node = &root_;
  for (int height = height_; height > 0; --height)
    node = &std::get<Cow<Inner>>(*node).write().children[static_cast<std::size_t>(slot_of(ref.chunk, height))];
  return std::get<Cow<LandmarkLeaf>>(*node).write();
}

// --- adding ---------------------------------------------------------------------------------------------------------

std::int64_t LandmarkStore::add(Landmark landmark) {
  landmark.id = next_id_++;
  if (root_.index() == 0) {
    root_ = Cow<LandmarkLeaf>();
    height_ = 0;
  }
  // What erasing has left as a chain goes first, so that the height follows the landmarks that are there.
  while (height_ > 0) {
    const auto& children = std::get<Cow<Inner>>(root_)->children;
    const auto is_used = [](const Node& child) { return child.index() != 0; };
    if (std::ranges::count_if(children, is_used) != 1) break;
    const Node& only = *std::ranges::find_if(children, is_used);
    if (--height_ > 0) {
      root_ = Cow<Inner>(std::get<Cow<Inner>>(only));
    } else {
      root_ = Cow<LandmarkLeaf>(std::get<Cow<LandmarkLeaf>>(only));
    }
  }
  if (std::optional<Split> split = add_below(root_, height_, landmark)) {
    if (height_ == kMaxHeight) throw Error("a map's tree of landmarks is full");
    Inner root;
    root.children[0] = std::move(root_);
    root.boxes[0] = split->box;
    root.children[1] = std::move(split->sibling);
    root.boxes[1] = split->sibling_box;
    root_ = Cow<Inner>(std::move(root));
    ++height_;
  }
  ++count_;
  return landmark.id;
}

std::optional<LandmarkStore::Split> LandmarkStore::add_below(Node& node, int height, const Landmark& landmark) {
  if (height == 0) return add_to_leaf(std::get<Cow<LandmarkLeaf>>(node).write(), landmark);

  // Into the child whose box grows least; of equal ones the smallest, then the first. Half the perimeter and not the
  // area, because the box of landmarks in a row has none.
  Inner& inner = std::get<Cow<Inner>>(node).write();
  const double east = landmark.mean.x();
  const double north = landmark.mean.y();
  std::size_t best = kFanOut;
  double best_growth = 0.0;
  double best_size = 0.0;
  for (std::size_t s = 0; s < kFanOut; ++s) {
    if (inner.children[s].index() == 0) continue;
    const double size = inner.boxes[s].half_perimeter();
    const double growth = inner.boxes[s].half_perimeter_with(east, north) - size;
    if (best == kFanOut || growth < best_growth || (growth == best_growth && size < best_size)) {
      best = s;
      best_growth = growth;
      best_size = size;
    }
  }
  std::optional<Split> split = add_below(inner.children[best], height - 1, landmark);
  if (!split) {
    inner.boxes[best].include(east, north);
    return std::nullopt;
  }
  inner.boxes[best] = split->box;
  return attach(inner, std::move(split->sibling), split->sibling_box);
}

std::optional<LandmarkStore::Split> LandmarkStore::add_to_leaf(LandmarkLeaf& leaf, const Landmark& landmark) {
  if (leaf.free_place() < kLeafSize) {
    leaf.put(leaf.free_place(), landmark);
    return std::nullopt;
  }
  const LandmarkBox whole = leaf.box();
  const auto& column = whole.is_wider_than_high() ? leaf.east : leaf.north;
  const auto stays = lower_half<kLeafSize>([&](std::size_t i) { return column[i]; });
  Cow<LandmarkLeaf> sibling;
  LandmarkLeaf& other = sibling.write();
  for (int i = 0; i < kLeafSize; ++i) {
    if (stays[static_cast<std::size_t>(i)]) continue;
    other.put(other.free_place(), leaf.get(i));
    leaf.free(i);
  }
  const double here =
      leaf.box().half_perimeter_with(landmark.mean.x(), landmark.mean.y()) - leaf.box().half_perimeter();
  const double there =
      other.box().half_perimeter_with(landmark.mean.x(), landmark.mean.y()) - other.box().half_perimeter();
  LandmarkLeaf& home = here <= there ? leaf : other;
  home.put(home.free_place(), landmark);
  Split split;
  split.box = leaf.box();
  split.sibling_box = other.box();
  split.sibling = std::move(sibling);
  return split;
}

std::optional<LandmarkStore::Split> LandmarkStore::attach(Inner& inner, Node node, const LandmarkBox& box) {
  const auto slot = std::ranges::find_if(inner.children, [](const Node& child) { return child.index() == 0; });
  if (slot != inner.children.end()) {
    inner.boxes[static_cast<std::size_t>(slot - inner.children.begin())] = box;
    *slot = std::move(node);
    return std::nullopt;
  }
  LandmarkBox whole = inner.box();
  whole.include(box);
  const bool by_east = whole.is_wider_than_high();
  const auto box_of = [&](std::size_t s) -> const LandmarkBox& { return s < kFanOut ? inner.boxes[s] : box; };
  const auto stays = lower_half<kFanOut + 1>([&](std::size_t s) {
    const LandmarkBox& b = box_of(s);
    return by_east ? static_cast<double>(b.low_east) + b.high_east : static_cast<double>(b.low_north) + b.high_north;
  });
  Inner kept;
  Inner moved;
  std::size_t kept_count = 0;
  std::size_t moved_count = 0;
  const auto give = [&](std::size_t s, Node&& child) {
    Inner& home = stays[s] ? kept : moved;
    const std::size_t place = stays[s] ? kept_count++ : moved_count++;
    home.boxes[place] = box_of(s);
    home.children[place] = std::move(child);
  };
  for (std::size_t s = 0; s < kFanOut; ++s) give(s, std::move(inner.children[s]));
  give(kFanOut, std::move(node));
  inner = std::move(kept);
  Split split;
  split.box = inner.box();
  split.sibling_box = moved.box();
  split.sibling = Cow<Inner>(std::move(moved));
  return split;
}

// --- writing and erasing --------------------------------------------------------------------------------------------

void LandmarkStore::write(LandmarkRef ref, const Landmark& landmark) {
  Node* node = &root_;
  for (int height = height_; height > 0; --height) {
    Inner& inner = std::get<Cow<Inner>>(*node).write();
    const auto slot = static_cast<std::size_t>(slot_of(ref.chunk, height));
    inner.boxes[slot].include(landmark.mean.x(), landmark.mean.y());
    node = &inner.children[slot];
  }
  LandmarkLeaf& leaf = std::get<Cow<LandmarkLeaf>>(*node).write();
  const std::int64_t id = leaf.id[static_cast<std::size_t>(ref.place)];
  leaf.put(ref.place, landmark);
  leaf.id[static_cast<std::size_t>(ref.place)] = id;
}

void LandmarkStore::write_log_odds(LandmarkRef ref, float log_odds) {
  leaf_for_writing(ref).log_odds[static_cast<std::size_t>(ref.place)] = log_odds;
}

void LandmarkStore::erase(LandmarkRef ref) {
  erase_below(root_, height_, ref);
  --count_;
}

LandmarkBox LandmarkStore::erase_below(Node& node, int height, LandmarkRef ref) {
  LandmarkBox box;
  bool is_empty = false;
  if (height == 0) {
    LandmarkLeaf& leaf = std::get<Cow<LandmarkLeaf>>(node).write();
    leaf.free(ref.place);
    is_empty = leaf.used == 0;
    box = leaf.box();
  } else {
    Inner& inner = std::get<Cow<Inner>>(node).write();
    const auto slot = static_cast<std::size_t>(slot_of(ref.chunk, height));
    inner.boxes[slot] = erase_below(inner.children[slot], height - 1, ref);
    is_empty = inner.is_empty();
    box = inner.box();
  }
  if (is_empty) node = std::monostate{};
  return box;
}

// --- counting -------------------------------------------------------------------------------------------------------

std::size_t LandmarkStore::bytes_of(std::span<const LandmarkStore* const> stores) {
  std::unordered_set<const void*> seen;
  std::size_t bytes = 0;
  for (const LandmarkStore* store : stores) {
    for_nodes(store->root_, [&](const Node& node) {
      if (!seen.insert(identity(node)).second) return false;
      const auto* leaf = std::get_if<Cow<LandmarkLeaf>>(&node);
      bytes += leaf != nullptr ? (*leaf)->bytes() : sizeof(Inner);
      return true;
    });
  }
  return bytes;
}

int LandmarkStore::leaves_not_shared_with(const LandmarkStore& other) const {
  std::unordered_set<const void*> theirs;
  for_nodes(other.root_, [&](const Node& node) { return theirs.insert(identity(node)).second; });
  int count = 0;
  for_nodes(root_, [&](const Node& node) {
    if (theirs.contains(identity(node))) return false;
    count += std::holds_alternative<Cow<LandmarkLeaf>>(node);
    return true;
  });
  return count;
}

}  // namespace waymark::feature_map
