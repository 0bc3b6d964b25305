// SPDX-License-Identifier: Apache-2.0
// How a store is written into a checkpoint and read back. Nodes that several stores share are written once.
#include <cmath>
#include <limits>
#include <set>
#include <string>

#include "map_modules/feature_map/landmarks/landmark_store.hpp"
#include "waymark/base/error.hpp"
#include "waymark/memory/shared_archive.hpp"

namespace waymark::feature_map {

namespace {

enum class Kind : std::uint8_t { kEmpty = 0, kLeaf = 1, kInner = 2 };
constexpr Kind last_of(Kind /*kind*/) { return Kind::kInner; }

constexpr double kFarthest = 1e9;               // a landmark from the map's origin [m]
constexpr std::int32_t kMostCounted = 1 << 30;  // views, sightings

void check(bool is_right, const char* what) {
  if (!is_right) throw DataError(std::string("checkpoint: landmarks: ") + what);
}

template <class Archive>
void serialize_landmark(Archive& archive, Landmark& landmark) {
  archive(landmark.mean, landmark.P, landmark.P_floor);
  auto bins = static_cast<std::uint32_t>(landmark.signature.size());
  archive(bins);
  if constexpr (Archive::kReads) {
    check(bins <= Signature::kMaxBins, "a signature with too many bins");
    if (bins > 0) landmark.signature = Signature::uniform(bins);
  }
  for (float& bin : landmark.signature) archive.within(bin, 0.0f, std::numeric_limits<float>::max());
  archive.within(landmark.signature_views, 0, kMostCounted);
  archive(landmark.identity, landmark.log_odds);
  archive.within(landmark.sightings, 0, kMostCounted);
  archive(landmark.id, landmark.birth, landmark.last_seen);
}

void save_leaf(const LandmarkLeaf& leaf, OutArchive& out) {
  out.value(leaf.used);
  for (int place = 0; place < LandmarkLeaf::kSize; ++place) {
    if (!leaf.has(place)) continue;
    Landmark landmark = leaf.get(place);
    serialize_landmark(out, landmark);
  }
}

void load_leaf(InArchive& in, std::int64_t next_id, LandmarkLeaf& leaf) {
  std::uint32_t used = 0;
  in.value(used);
  check(used != 0, "an empty leaf");
  for (int place = 0; place < LandmarkLeaf::kSize; ++place) {
    if (((used >> static_cast<unsigned>(place)) & 1u) == 0) continue;
    Landmark landmark;
    serialize_landmark(in, landmark);
    check(landmark.mean.cwiseAbs().maxCoeff() <= kFarthest, "a landmark at no place");
    check((landmark.P.diagonal().array() >= 0.0).all(), "a landmark of negative variance");
    check(landmark.id >= 0 && landmark.id < next_id, "an id that was never given");
    leaf.put(place, landmark);
  }
}

}  // namespace

/// A node as read, with what the nodes above must know about it.
struct LandmarkStore::Loaded {
  Node node;
  LandmarkBox box;
  std::size_t count = 0;
  int height = 0;
};

void LandmarkStore::save(OutArchive& out) const {
  out.section("landmarks", 5);
  out.value(static_cast<std::uint64_t>(count_));
  out.value(next_id_);
  out.value(static_cast<std::int32_t>(height_));
  save_node(root_, out);
}

void LandmarkStore::save_node(const Node& node, OutArchive& out) {
  const auto* leaf = std::get_if<Cow<LandmarkLeaf>>(&node);
  const auto* inner = std::get_if<Cow<Inner>>(&node);
  out.value(leaf != nullptr ? Kind::kLeaf : inner != nullptr ? Kind::kInner : Kind::kEmpty);
  if (node.index() == 0) return;
  save_shared(identity(node), out, [&] {
    if (leaf != nullptr) {
      save_leaf(leaf->read(), out);
      return;
    }
    for (std::size_t s = 0; s < kFanOut; ++s) {
      const LandmarkBox& box = (*inner)->boxes[s];
      for (const float side : {box.low_east, box.low_north, box.high_east, box.high_north}) out.value(side);
      save_node((*inner)->children[s], out);
    }
  });
}

void LandmarkStore::load(InArchive& in) {
  check(in.section("landmarks", 5) == 5, "written by a version whose maps are not read any more");
  LandmarkStore store;
  std::uint64_t count = 0;
  std::int32_t height = 0;
  in.value(count);
  in.within(store.next_id_, 0, std::int64_t{1} << 62);
  in.within(height, 0, kMaxHeight);
  Loaded root = load_node(in, height, store.next_id_);
  check(root.count == count, "another number of landmarks than announced");
  // As a tree without shared branches: one that holds itself several times would take for ever to search.
  std::set<const void*> seen;
  for_nodes(root.node, [&](const Node& node) {
    check(seen.insert(identity(node)).second, "a node that stands in two places");
    return true;
  });
  store.root_ = std::move(root.node);
  store.height_ = height;
  store.count_ = count;
  *this = std::move(store);
}

LandmarkStore::Loaded LandmarkStore::load_node(InArchive& in, int height, std::int64_t next_id) {
  Kind kind{};
  in.value(kind);
  Loaded empty;
  empty.height = height;
  if (kind == Kind::kEmpty) return empty;
  check(kind == (height == 0 ? Kind::kLeaf : Kind::kInner), "a node at the wrong height");
  Loaded loaded = load_shared<Loaded>(
      in, [&] { return height == 0 ? load_leaf_node(in, next_id) : load_inner_node(in, height, next_id); });
  check(loaded.height == height, "a node at the wrong height");
  return loaded;
}

LandmarkStore::Loaded LandmarkStore::load_leaf_node(InArchive& in, std::int64_t next_id) {
  Cow<LandmarkLeaf> leaf;
  load_leaf(in, next_id, leaf.write());
  Loaded loaded;
  loaded.box = leaf->box();
  loaded.count = static_cast<std::size_t>(leaf->count());
  loaded.node = std::move(leaf);
  return loaded;
}

LandmarkStore::Loaded LandmarkStore::load_inner_node(InArchive& in, int height, std::int64_t next_id) {
  Loaded loaded;
  loaded.height = height;
  Inner inner;
  for (std::size_t s = 0; s < kFanOut; ++s) {
    LandmarkBox& box = inner.boxes[s];
    in.bytes(&box, sizeof box);  // of an empty slot its sides are infinite
    Loaded child = load_node(in, height - 1, next_id);
    if (child.count == 0) {
      check(child.node.index() == 0, "an empty node");
      box = {};
    } else {
      const bool is_finite = std::isfinite(box.low_east) && std::isfinite(box.low_north) &&
                             std::isfinite(box.high_east) && std::isfinite(box.high_north);
      check(is_finite && box.contains(child.box), "a box that does not hold what is in it");
    }
    inner.children[s] = std::move(child.node);
    loaded.count += child.count;
  }
  check(!inner.is_empty(), "an empty node");
  loaded.box = inner.box();
  loaded.node = Cow<Inner>(std::move(inner));
  return loaded;
}

}  // namespace waymark::feature_map
