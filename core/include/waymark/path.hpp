// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "waymark/api.hpp"
#include "waymark/archive.hpp"
#include "waymark/lineage.hpp"
#include "waymark/snapshot.hpp"

namespace waymark {

/// A particle's path, shared with its relatives.
class WAYMARK_API Path {
 public:
  void append(Time stamp, const Pose& T_map_base) { poses_.append({stamp, T_map_base}); }
  /// From the first to the last.
  std::vector<StampedPose> poses() const { return poses_.items(); }
  bool empty() const { return poses_.empty(); }

  void save(OutArchive& out) const;
  void load(InArchive& in);

 private:
  Lineage<StampedPose> poses_;
};

}  // namespace waymark
