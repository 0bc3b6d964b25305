// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "waymark/base/api.hpp"
#include "waymark/interface/snapshot.hpp"
#include "waymark/io/archive.hpp"
#include "waymark/memory/lineage.hpp"

namespace waymark::particles {

/// A particle's path, shared with its relatives. Between two mapping steps it is dead reckoning; what the next one
/// finds wrong with that is spread over it.
class WAYMARK_API Path {
 public:
  void append(Time stamp, const Pose& T_map_base) { poses_.append({stamp, T_map_base}); }
  /// A pose of dead reckoning since the last `append`.
  void append_tentative(Time stamp, const Pose& T_map_base) { tentative_.push_back({stamp, T_map_base}); }
  /// Dead reckoning led to `predicted`, but the base was at `found`: every tentative pose is moved by its share of
  /// that, which is its share of the motion since the last `append`, and is tentative no more.
  void settle(const Pose& predicted, const Pose& found);
  /// From the first to the last.
  std::vector<StampedPose> poses() const;
  bool empty() const { return poses_.empty() && tentative_.empty(); }

  template <class Archive>
  void serialize(Archive& archive) {
    const std::uint32_t version = archive.section("path", 2);
    poses_.serialize(archive, fields_of_pose);
    if (version >= 2) archive.each(tentative_, fields_of_pose);
  }

 private:
  static constexpr auto fields_of_pose = [](auto& archive, StampedPose& pose) {
    archive(pose.stamp, pose.T_map_base.p, pose.T_map_base.q);
  };

  Lineage<StampedPose> poses_;
  std::vector<StampedPose> tentative_;
};

}  // namespace waymark::particles
