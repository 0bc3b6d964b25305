// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "waymark/api.hpp"
#include "waymark/archive.hpp"
#include "waymark/snapshot.hpp"

namespace waymark {

/// A particle's path as a leaf of the ancestry tree: particles with common ancestors share the trunk, and what no
/// living particle descends from is freed. Copying is O(1).
class WAYMARK_API Path {
 public:
  Path() = default;
  Path(const Path&) = default;
  Path(Path&&) noexcept = default;
  Path& operator=(const Path& other);
  Path& operator=(Path&& other) noexcept;
  ~Path();

  void append(Time stamp, const Pose& T_map_base);
  /// From the root to this leaf.
  std::vector<StampedPose> poses() const;
  bool empty() const { return leaf_ == nullptr; }

  void save(OutArchive& out) const;
  void load(InArchive& in);

 private:
  struct Node {
    StampedPose pose;
    std::shared_ptr<Node> parent;
    ~Node();
  };
  /// Frees a chain without recursion: a path of an hour has 10^5 nodes.
  static void release(std::shared_ptr<Node> node);

  std::shared_ptr<Node> leaf_;
};

}  // namespace waymark
