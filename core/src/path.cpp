// SPDX-License-Identifier: Apache-2.0
#include "waymark/path.hpp"

#include <algorithm>

namespace waymark {

Path& Path::operator=(const Path& other) {
  if (this != &other) {
    std::shared_ptr<Node> leaf = other.leaf_;  // before the release, which may free what both share
    release(std::move(leaf_));
    leaf_ = std::move(leaf);
  }
  return *this;
}

Path& Path::operator=(Path&& other) noexcept {
  if (this != &other) {
    release(std::move(leaf_));
    leaf_ = std::move(other.leaf_);
  }
  return *this;
}

Path::~Path() { release(std::move(leaf_)); }

// Whoever holds the last handle (an archive, another thread's path) frees the rest of the chain, so this must not
// recurse either.
Path::Node::~Node() { release(std::move(parent)); }

void Path::release(std::shared_ptr<Node> node) {
  while (node != nullptr && node.use_count() == 1) node = std::move(node->parent);
}

void Path::append(Time stamp, const Pose& T_map_base) {
  leaf_ = std::make_shared<Node>(Node{{stamp, T_map_base}, std::move(leaf_)});
}

std::vector<StampedPose> Path::poses() const {
  std::vector<StampedPose> result;
  for (const Node* node = leaf_.get(); node != nullptr; node = node->parent.get()) result.push_back(node->pose);
  std::reverse(result.begin(), result.end());
  return result;
}

void Path::save(OutArchive& out) const {
  // Leaf first, down to the first node that another path has already written.
  out.section("path", 1);
  for (const Node* node = leaf_.get(); node != nullptr; node = node->parent.get()) {
    out.value(true);
    if (!out.first_sight(node)) return;
    out.value(node->pose.stamp.time_since_epoch().count());
    out.value(node->pose.T_map_base.p);
    out.value(Eigen::Vector4d(node->pose.T_map_base.q.coeffs()));
  }
  out.value(false);
}

void Path::load(InArchive& in) {
  in.section("path", 1);
  release(std::move(leaf_));
  std::shared_ptr<Node>* slot = &leaf_;
  while (true) {
    bool more = false;
    in.value(more);
    if (!more) return;
    std::uint64_t number = 0;
    if (auto known = in.shared(number)) {
      *slot = std::static_pointer_cast<Node>(known);
      return;
    }
    auto node = std::make_shared<Node>();
    in.remember(number, node);
    std::int64_t stamp = 0;
    Eigen::Vector4d q;
    in.value(stamp);
    in.value(node->pose.T_map_base.p);
    in.value(q);
    node->pose.stamp = Time{Duration{stamp}};
    node->pose.T_map_base.q = Eigen::Quaterniond(q);
    *slot = node;
    slot = &node->parent;
  }
}

}  // namespace waymark
