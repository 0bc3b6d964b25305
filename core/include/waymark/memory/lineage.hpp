// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "waymark/base/error.hpp"
#include "waymark/io/archive.hpp"

namespace waymark {

/// A sequence of items of a particle and its ancestors, as a leaf of the ancestry tree. Particles with common ancestors
/// share the trunk. Branches without a living descendant are freed. Copying is O(1).
template <class Item>
class Lineage {
 public:
  Lineage() = default;
  Lineage(const Lineage&) = default;
  Lineage(Lineage&& other) noexcept : leaf_(std::move(other.leaf_)), size_(std::exchange(other.size_, 0)) {}
  Lineage& operator=(const Lineage& other) {
    if (this != &other) set(other.leaf_, other.size_);
    return *this;
  }
  Lineage& operator=(Lineage&& other) noexcept {
    if (this != &other) set(std::move(other.leaf_), std::exchange(other.size_, 0));
    return *this;
  }
  ~Lineage() { release(std::move(leaf_)); }

  void append(Item item) {
    leaf_ = std::make_shared<Node>(Node{std::move(item), std::move(leaf_)});
    ++size_;
  }
  /// Removes the newest item; others that share it keep it. Must not be empty.
  void drop_last() {
    std::shared_ptr<Node> leaf = std::exchange(leaf_, leaf_->parent);
    release(std::move(leaf));
    --size_;
  }
  bool empty() const { return leaf_ == nullptr; }
  /// Number of items, from the root to this leaf.
  std::size_t size() const { return size_; }
  /// The newest item, or null.
  const Item* last() const { return leaf_ == nullptr ? nullptr : &leaf_->item; }

  /// From the root to this leaf.
  std::vector<Item> items() const { return items_since({}); }
  /// The items from the last one that both lineages share; all if they share none.
  std::vector<Item> items_since(const Lineage& known) const {
    const Node* other = known.leaf_.get();
    std::size_t others = known.size_;
    std::vector<Item> result;
    std::size_t own = size_;
    for (const Node* node = leaf_.get(); node != nullptr; node = node->parent.get(), --own) {
      result.push_back(node->item);
      for (; others > own; --others) other = other->parent.get();
      if (node == other) break;
    }
    std::reverse(result.begin(), result.end());
    return result;
  }

  /// Removes every second one of the first `count` items of each lineage. What these lineages share they share
  /// afterwards, too; other lineages keep all. Beside the new items it needs memory for those only that are shared: of
  /// a robot that drives for months, large blocks that come and go would fragment the heap.
  static void thin(std::span<Lineage* const> lineages, std::size_t count) {
    std::unordered_map<const Node*, std::shared_ptr<Node>> thinned;  // of what is shared
    std::vector<const Node*> removed;                                // shared ones, down to the next that is kept
    std::vector<std::shared_ptr<Node>> leaves;  // set at the end, since the old ones count what is shared
    leaves.reserve(lineages.size());
    for (const Lineage* lineage : lineages) {
      std::shared_ptr<Node> leaf;
      std::shared_ptr<Node>* slot = &leaf;
      std::size_t place = lineage->size_;
      removed.clear();
      for (const std::shared_ptr<Node>* node = &lineage->leaf_; *node != nullptr; node = &(*node)->parent) {
        const bool is_shared = node->use_count() > 1;
        if (const auto known = is_shared ? thinned.find(node->get()) : thinned.end(); known != thinned.end()) {
          *slot = known->second;
          break;
        }
        --place;
        if (place < count && place % 2 != 0) {
          if (is_shared) removed.push_back(node->get());
          continue;
        }
        *slot = std::make_shared<Node>(Node{(*node)->item, nullptr});
        if (is_shared) thinned.emplace(node->get(), *slot);
        for (const Node* one : removed) thinned.emplace(one, *slot);
        removed.clear();
        slot = &(*slot)->parent;
      }
      for (const Node* one : removed) thinned.emplace(one, *slot);
      leaves.push_back(std::move(leaf));
    }
    for (std::size_t i = 0; i < leaves.size(); ++i) {
      Lineage& lineage = *lineages[i];
      lineage.set(std::move(leaves[i]), lineage.size_ - std::min(count, lineage.size_) / 2);
    }
  }

  /// Writes the items, leaf first, down to the first that another lineage has already written. `fields(archive, item)`
  /// lists an item's fields, for both directions.
  template <class Fields>
  void serialize(OutArchive& out, const Fields& fields) {
    for (Node* node = leaf_.get(); node != nullptr; node = node->parent.get()) {
      out.value(true);
      if (!out.first_sight(node)) return;
      fields(out, node->item);
    }
    out.value(false);
  }

  /// Reads what that wrote. Throws DataError if an item would descend from itself.
  template <class Fields>
  void serialize(InArchive& in, const Fields& fields) {
    set(nullptr, 0);
    std::shared_ptr<Node>* slot = &leaf_;
    std::optional<std::uint64_t> leaf;  // number of the first item that is new: all before it have their ancestors
    while (true) {
      bool more = false;
      in.value(more);
      if (!more) break;
      std::uint64_t number = 0;
      if (auto known = in.template shared<Node>(number)) {
        if (leaf && number >= *leaf) throw DataError("checkpoint: an item of a lineage descends from itself");
        *slot = std::move(known);
        break;
      }
      auto node = std::make_shared<Node>();
      in.remember(number, node);
      if (!leaf) leaf = number;
      fields(in, node->item);
      *slot = node;
      slot = &node->parent;
    }
    for (const Node* node = leaf_.get(); node != nullptr; node = node->parent.get()) ++size_;
  }

 private:
  struct Node {
    Item item;
    std::shared_ptr<Node> parent;
    // Whoever holds the last handle (an archive, another thread's lineage) frees the rest of the chain, so this must
    // not recurse either.
    ~Node() { release(std::move(parent)); }
  };
  /// Frees a chain without recursion: a path of an hour has 10^5 nodes.
  static void release(std::shared_ptr<Node> node) {
    while (node != nullptr && node.use_count() == 1) node = std::move(node->parent);
  }

  /// Takes another leaf. The old one is released last: it may hold what both share.
  void set(std::shared_ptr<Node> leaf, std::size_t size) {
    std::shared_ptr<Node> old = std::exchange(leaf_, std::move(leaf));
    release(std::move(old));
    size_ = size;
  }

  std::shared_ptr<Node> leaf_;
  std::size_t size_ = 0;
};

}  // namespace waymark
