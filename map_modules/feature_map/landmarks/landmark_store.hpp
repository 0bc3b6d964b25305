// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <variant>

#include "map_modules/feature_map/landmarks/landmark.hpp"
#include "map_modules/feature_map/landmarks/landmark_leaf.hpp"
#include "waymark/io/archive.hpp"
#include "waymark/memory/cow.hpp"

namespace waymark::feature_map {

/// Where a landmark lies: the leaf as the way to it from the root (three bits a level), and the place in it. Stays
/// valid through `write`, `write_log_odds` and `erase` of this or of other landmarks, until the next `add`.
struct LandmarkRef {
  std::int32_t chunk = -1;
  std::int32_t place = -1;

  bool operator==(const LandmarkRef&) const = default;
};

/// A particle's landmarks in an R-tree (A. Guttman, SIGMOD 1984) whose nodes are shared between particles until one of
/// them writes (path copying: J. Driscoll et al., JCSS 1989). Copying the store copies one handle. `add`, `write` and
/// `erase` clone at most the nodes between the root and one leaf; they and a search take a time logarithmic in the
/// number of landmarks, if their density is bounded. All leaves have the same depth. Visits come in the order of the
/// nodes' slots, which only the history of the store decides.
class LandmarkStore {
 public:
  static constexpr int kLeafSize = LandmarkLeaf::kSize;
  static constexpr int kFanOut = 8;
  static constexpr int kMaxHeight = 10;  ///< levels above the leaves; more than a LandmarkRef can name never arise

  std::size_t size() const { return count_; }
  /// Levels of inner nodes above the leaves.
  int height() const { return height_; }

  /// A copy of a landmark, or a view where it is stored.
  Landmark at(LandmarkRef ref) const { return stored(ref); }
  StoredLandmark stored(LandmarkRef ref) const { return {leaf_of(ref), ref.place}; }

  /// Calls visit(ref, stored landmark) for all landmarks within `radius` of `center`, in a fixed order.
  template <class Visit>
  void for_near(const Eigen::Vector2d& center, double radius, const Visit& visit) const {
    search(root_, height_, 0, Disc{center.x(), center.y(), radius * radius}, false, visit);
  }
  template <class Visit>
  void for_all(const Visit& visit) const {
    search(root_, height_, 0, Disc{}, true, [&](LandmarkRef, StoredLandmark landmark) { visit(landmark); });
  }

  /// Adds a landmark under a fresh id and returns that. All refs become invalid: leaves and nodes may be split. Throws
  /// Error if the tree would become higher than kMaxHeight, which takes millions of landmarks.
  std::int64_t add(Landmark landmark);
  /// Replaces a landmark; its id stays. Boxes on the way grow where it has moved out of them.
  void write(LandmarkRef ref, const Landmark& landmark);
  void write_log_odds(LandmarkRef ref, float log_odds);
  /// Nothing else changes its place. A leaf or node that becomes empty is given back; its slot is used again by `add`.
  void erase(LandmarkRef ref);

  void save(OutArchive& out) const;
  /// Throws DataError if what is read is not a valid tree.
  void load(InArchive& in);

  /// Bytes of all nodes of these stores, each shared node counted once.
  static std::size_t bytes_of(std::span<const LandmarkStore* const> stores);
  /// Leaves, and those that this store does not share with `other`, for tests of copy-on-write.
  int leaves() const { return leaves_not_shared_with({}); }
  int leaves_not_shared_with(const LandmarkStore& other) const;
  bool shares_root_with(const LandmarkStore& other) const { return identity(root_) == identity(other.root_); }

 private:
  struct Inner;
  using Node = std::variant<std::monostate, Cow<LandmarkLeaf>, Cow<Inner>>;
  struct Inner {
    std::array<LandmarkBox, kFanOut> boxes;  ///< of empty slots: inside out, so that no search enters
    std::array<Node, kFanOut> children;

    LandmarkBox box() const;
    bool is_empty() const;
  };
  struct Split {
    Node sibling;
    LandmarkBox box;          ///< of what has stayed
    LandmarkBox sibling_box;  ///< of what has moved
  };
  struct Disc {
    double east = 0.0;
    double north = 0.0;
    double radius_square = 0.0;
  };
  struct Loaded;

  static std::int32_t slot_of(std::int32_t chunk, int height) { return (chunk >> (3 * (height - 1))) & (kFanOut - 1); }
  static const void* identity(const Node& node);
  /// Calls visit(node) for this node and, where it returns true, for those below.
  template <class Visit>
  static void for_nodes(const Node& node, const Visit& visit);

  template <class Visit>
  static void search(const Node& node, int height, std::int32_t path, const Disc& disc, bool is_inside,
                     const Visit& visit);
  const LandmarkLeaf& leaf_of(LandmarkRef ref) const;
  LandmarkLeaf& leaf_for_writing(LandmarkRef ref);
  static std::optional<Split> add_below(Node& node, int height, const Landmark& landmark);
  static std::optional<Split> add_to_leaf(LandmarkLeaf& leaf, const Landmark& landmark);
  static std::optional<Split> attach(Inner& inner, Node node, const LandmarkBox& box);
  static LandmarkBox erase_below(Node& node, int height, LandmarkRef ref);
  static void save_node(const Node& node, OutArchive& out);
  static Loaded load_node(InArchive& in, int height, std::int64_t next_id);
  static Loaded load_leaf_node(InArchive& in, std::int64_t next_id);
  static Loaded load_inner_node(InArchive& in, int height, std::int64_t next_id);

  Node root_;
  int height_ = 0;
  std::size_t count_ = 0;
  std::int64_t next_id_ = 0;
};

template <class Visit>
void LandmarkStore::for_nodes(const Node& node, const Visit& visit) {
  if (node.index() == 0 || !visit(node)) return;
  if (const auto* inner = std::get_if<Cow<Inner>>(&node)) {
    for (const Node& child : (*inner)->children) for_nodes(child, visit);
  }
}

template <class Visit>
void LandmarkStore::search(const Node& node, int height, std::int32_t path, const Disc& disc, bool is_inside,
                           const Visit& visit) {
  if (height > 0) {
    const auto* inner = std::get_if<Cow<Inner>>(&node);
    if (inner == nullptr) return;
    for (std::int32_t slot = 0; slot < kFanOut; ++slot) {
      const auto s = static_cast<std::size_t>(slot);
      const LandmarkBox& box = (*inner)->boxes[s];
      if (!is_inside && !(box.nearest_square(disc.east, disc.north) <= disc.radius_square)) continue;
      const bool all = is_inside || box.farthest_square(disc.east, disc.north) <= disc.radius_square;
      search((*inner)->children[s], height - 1, path * kFanOut + slot, disc, all, visit);
    }
    return;
  }
  const auto* handle = std::get_if<Cow<LandmarkLeaf>>(&node);
  if (handle == nullptr) return;
  const LandmarkLeaf& leaf = handle->read();
  for (std::uint32_t left = leaf.used; left != 0; left &= left - 1) {
    const int place = std::countr_zero(left);
    const double x = leaf.east[static_cast<std::size_t>(place)] - disc.east;
    const double y = leaf.north[static_cast<std::size_t>(place)] - disc.north;
    if (is_inside || x * x + y * y <= disc.radius_square) visit(LandmarkRef{path, place}, StoredLandmark(leaf, place));
  }
}

}  // namespace waymark::feature_map
